"""The picture and the recording that the examples read."""

from cnnsim import read_picture
from tactile.sources import open_source
from tests.kits.example_files import PICTURE, RECORDING, SCENE, scan


def test_they_are_what_the_code_makes() -> None:
    assert abs(read_picture(PICTURE) - scan()).max() <= 1 / 255
    assert RECORDING.stat().st_size < 300_000
    kept, made = open_source(RECORDING), open_source(SCENE)
    assert [array.name for array in kept.arrays] == [array.name for array in made.arrays]
    for ours, theirs in zip(kept, made, strict=True):
        assert abs(ours.values - theirs.values).max() < 1e-12
        if ours.t > 0.1:
            break
