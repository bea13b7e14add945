"""Scenes and arrays made in Python, without a file: typed, checked, short to look at."""

import numpy as np
import pytest

from cnnsim.support import InputError
from tactile import (
    Frame,
    Indenter,
    MovingContact,
    MovingLoad,
    Scene,
    TaxelArray,
    make_effect,
    open_source,
)
from tests.kits.paths import SCENES

PAD = TaxelArray("pad", 2, 2, 1.5e-3, 1.5e-3)
PATH = [(0.0, 0.0, 0.0, 0.0, 0.0, 0.0), (0.1, 0.0, 0.0, 0.0, 0.0, 0.5)]


def test_a_scene_is_what_its_file_would_be() -> None:
    read = open_source(SCENES / "grip.toml")
    assert isinstance(read, Scene)
    made = Scene(
        read.title, rate=200, duration=6.0, modulus=2.4e6, arrays=list(read.arrays),
        loads=[MovingLoad(load.finger, load.path.tolist()) for load in read.loads],
    )  # fmt: skip
    for a, b, _ in zip(read, made, range(500), strict=False):
        assert np.array_equal(a.values, b.values)


def test_effects_are_named_and_put_in_order() -> None:
    effects = [make_effect("read_noise", rms=1e-3), make_effect("finite_tip")]
    scene = Scene("s", 100, 0.1, 2.4e6, [PAD], [MovingLoad(0, PATH)], effects=effects)
    assert [name for name, _ in scene.effects] == ["finite_tip", "read_noise"]
    assert len(list(scene)) == 10
    for wrong, message in ((("read_nois", {}), "did you mean 'read_noise'"), (("read_noise", {"rm": 1}), "'rms'")):
        with pytest.raises(InputError, match=message):
            make_effect(wrong[0], **wrong[1])
    with pytest.raises(InputError, match="an effect wanted"):
        Scene("s", 100, 0.1, 2.4e6, [PAD], effects=["read_noise"])


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"rate": 0}, "rate 0, a positive number wanted"),
        ({"modulus": float("nan")}, "modulus nan"),
        ({"arrays": []}, "at least one"),
        ({"arrays": [PAD, PAD]}, "no name twice"),
        ({"arrays": [TaxelArray("f", 2, 2, 1e-3, 0.0, quantity="force", shear=False)]}, "array 'f' of force"),
        ({"loads": [MovingLoad(1, PATH)]}, "a finger from 0 to 0 wanted"),
    ],
)
def test_wrong_scenes_are_refused(change: dict[str, object], message: str) -> None:
    given: dict[str, object] = {"title": "s", "rate": 100, "duration": 0.1, "modulus": 2.4e6, "arrays": [PAD]}
    with pytest.raises(InputError, match=message):
        Scene(**(given | change))  # type: ignore[arg-type]  # some are wrong on purpose


def test_wrong_paths_are_refused() -> None:
    for path, message in (([], "shape"), ([(0, 1)], r"\(1, 2\)"), (PATH[::-1], "growing"), ("x", "finite numbers")):
        with pytest.raises(InputError, match=message):
            MovingLoad(0, path)
    with pytest.raises(InputError, match="friction -1"):
        MovingContact(0, Indenter("sphere", 1e-3), PATH, friction=-1)
    assert MovingContact(0, Indenter("sphere", 1e-3), PATH).path.shape == (2, 7)


def test_values_are_short_to_look_at() -> None:
    scene = Scene("s", 100, 0.1, 2.4e6, [PAD], [MovingLoad(0, PATH)])
    assert repr(scene) == "Scene('s', pad 2 x 2, 0.1 s at 100 Hz, 1 pressing, no effects)"
    assert repr(scene.loads[0]) == "MovingLoad(finger=0, 2 keyframes from 0 to 0.1 s)"
    assert "<td>pad</td><td>2 x 2 of strain</td>" in scene._repr_html_()
    frame = Frame(0, 0.5, 3, np.ones((2, 2, 3)), np.ones((2, 2), bool))
    assert repr(frame) == "Frame(finger=0, t=0.5, sequence=3, 2 x 2, 4 valid, 1 to 1)"
    large = Frame(0, 0.5, 3, np.zeros((128, 128, 3)), np.zeros((128, 128), bool))
    assert len(repr(large)) < 100
