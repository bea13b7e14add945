"""Features of windows of slides against their definitions; damaged slide files."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from cnnsim.support import InputError
from tactile.materials.features import feature_set
from tactile.materials.slide import Slide
from tactile.materials.slide_file import NEEDED, is_slide_file
from tactile.materials.spectra import memory, spectrum
from tactile.materials.windows import cut
from tactile.texture.figures import Texture
from tests.kits.touch.slides import slide, slides


def test_friction_and_roughness_equal_those_of_the_pipeline() -> None:
    one = slide("fine textile", 3)
    texture = Texture(128, 0.0)
    for force in one.force[:128]:
        shown = texture.update(force[None, None])
    friction, roughness = np.exp(feature_set("figures", 128, [one])(one.t[:128], one.force[:128]))
    assert friction == pytest.approx(shown.friction[0, 0], rel=1e-12)
    assert roughness == pytest.approx(shown.roughness[0, 0], rel=1e-12)


def test_spectrum_at_uneven_times() -> None:
    at = np.sort(np.random.default_rng(0).uniform(0, 2, 400))
    waves = spectrum(at, 3 * np.cos(2 * np.pi * 10 * at + 0.7)[None], np.array([10.0, 40.0]))
    assert abs(waves[0, 0]) == pytest.approx(3, rel=0.05)
    assert np.angle(waves[0, 0]) == pytest.approx(0.7, abs=0.05)
    assert abs(waves[0, 1]) < 0.6


def test_memory_is_the_lagged_mean_product() -> None:
    one, other = np.random.default_rng(1).normal(size=(2, 50))
    late = sum(one[n + 3] * other[n] for n in range(47)) / 50
    early = sum(one[n] * other[n + 2] for n in range(48)) / 50
    assert memory(one, other, np.array([3.0, -2.0])) == pytest.approx([late, early])
    between = memory(one, other, np.array([2.5]))
    assert between == pytest.approx(memory(one, other, np.array([2.0, 3.0])).mean())


def test_only_the_mean_normal_force_depends_on_the_unit() -> None:
    one = slide("fine textile", 5)
    features = feature_set("full", 128, [one])
    newtons, other = features(one.t[:128], one.force[:128]), features(one.t[:128], 7.0 * one.force[:128])
    assert len(features.names) == len(newtons) == len(set(features.names))
    differ = ~np.isclose(newtons, other, rtol=1e-6, atol=1e-8)
    assert [name for name, off in zip(features.names, differ, strict=True) if off] == ["mean normal"]


def test_bands_by_distance_do_not_depend_on_the_speed() -> None:
    """A wave of one length: its band in time moves with the speed, its band in distance does not."""

    def drawn(speed: float, known: bool) -> Slide:
        t = np.arange(512) / 200
        wave = np.sin(2 * np.pi * t * speed / 1e-3)
        force = np.column_stack([0.5 + 0.1 * wave, 0.01 * np.cos(40 * t), 1 + 0.2 * wave])
        return Slide(f"{speed}", t, force, "", 0, speed if known else None)

    def loudest(known: bool) -> list[int]:
        features = feature_set("full", 256, [drawn(0.02, known), drawn(0.04, known)])
        names = [n for n, name in enumerate(features.names) if name.startswith("normal ") and " to " in name]
        rows = [features(one.t[:256], one.force[:256], one.speed) for one in (drawn(0.02, known), drawn(0.04, known))]
        return [int(np.argmax(row[names])) for row in rows]

    by_distance, by_time = loudest(True), loudest(False)
    assert by_distance[0] == by_distance[1]
    assert by_time[1] - by_time[0] >= 1


def test_windows_without_contact_are_dropped_and_counted() -> None:
    one = slide("screw", 1)
    lifted = one.force.copy()
    lifted[100:160, 2] = 0.0
    lifted[20, 2] = 1e-6  # one short lift
    gap = one.t.copy()
    gap[350:] += 5.0
    table = cut([Slide("a", gap, lifted)], feature_set("figures", 100, [one]), 100)
    assert table.start.tolist() == [0, 200]
    assert table.dropped == 2
    assert np.exp(table.values[0, 0]) < 0.5  # the screw's friction is 0.45 at most


def test_too_short_slides_and_wrong_times_are_refused() -> None:
    with pytest.raises(InputError, match="no slide of 500 samples"):
        feature_set("full", 500, slides(1))
    with pytest.raises(InputError, match="at least 8 wanted"):
        feature_set("full", 4, slides(1))
    with pytest.raises(InputError, match="times that do not increase"):
        Slide("a", np.array([0.0, 0.0]), np.zeros((2, 3)))


@pytest.mark.parametrize("at", [6, 28])
def test_a_damaged_zip_directory_is_no_slide_file(tmp_path: Path, at: int) -> None:
    """Offset 6 of an entry is the version needed; at 28, a name that is not UTF-8 has the UTF-8 flag."""
    path = tmp_path / "s.npz"
    arrays: dict[str, Any] = {name: np.zeros(3) for name in NEEDED}
    np.savez(path, **arrays)
    assert is_slide_file(path)
    data = bytearray(path.read_bytes())
    entry = data.index(b"PK\x01\x02")
    if at == 6:
        data[entry + 6] = 200
    else:
        data[entry + 9] |= 8
        data[entry + 46] = 0x93
    path.write_bytes(data)
    assert not is_slide_file(path)
