"""Scenes: what a file names is computed, what it does not name is not even imported."""

import subprocess
import sys
import tomllib
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from tactile.elastic.halfspace import point_load_strain
from tactile.simulator.effects import ORDER
from tactile.simulator.scene_file.file import read_scene
from tactile.sources import open_source
from tests.kits.paths import ROOT
from tests.kits.touch.small_scene import LOAD, SCENE, SPHERE, TEXTURE, made, values

SCENES = sorted((ROOT / "examples" / "scenes").glob("*.toml"))


@pytest.mark.parametrize("path", SCENES, ids=[path.stem for path in SCENES])
def test_example_scenes_run_and_say_the_same_twice(path: Path) -> None:
    first, second = list(open_source(path)), list(open_source(path))
    assert first
    assert all(np.isfinite(frame.values).all() for frame in first)
    assert all(np.array_equal(a.values, b.values) for a, b in zip(first, second, strict=True))
    assert [frame.t for frame in first] == sorted(frame.t for frame in first)


@pytest.mark.parametrize(
    ("extra", "module"),
    [
        ("", None),
        ("[effect.finite_thickness]\nthickness_mm = 3\n", "effects.finite_thickness"),
    ],
)
def test_what_a_scene_does_not_name_is_not_imported(tmp_path: Path, extra: str, module: str | None) -> None:
    load = '[[load]]\nfinger = "left"\npath = [[0, 0, 0, 0, 0, 1]]\n'
    (tmp_path / "s.toml").write_text(SCENE + load + extra)
    script = (
        "import sys; from pathlib import Path; from tactile.sources import open_source\n"
        f"assert len(list(open_source(Path({str(tmp_path / 's.toml')!r})))) == 30\n"
        "print(*(name for name in sys.modules if name.startswith('tactile.')))\n"
    )
    done = subprocess.run([sys.executable, "-c", script], cwd=ROOT, capture_output=True, text=True, check=True)
    loaded = {name.removeprefix("tactile.simulator.") for name in done.stdout.split()}
    effects = {name for name in loaded if name.startswith("effects.")}
    assert effects == ({module} if module else set())
    unnamed = {"auto_effects", "explain", "sizes", "scene_file.contact_tables"}
    unnamed |= {f"contacts.{name}" for name in ("sliding_texture", "materials", "traction_map")}
    unnamed |= {"tactile.elastic.lines"} | ({"tactile.elastic.discs"} if "thickness" not in extra else set())
    assert not loaded & unnamed
    assert ("effects" in loaded) == bool(module)


def test_a_load_alone_is_the_half_space() -> None:
    scene = made(load=[LOAD])
    times = np.arange(30) / 100
    wanted = point_load_strain(scene.arrays[0].positions(), 1.5e-3, scene.loads_at(0, times)[:, None, None], 2.4e6)
    assert np.abs(values(scene) - wanted).max() < 1e-14 * np.abs(wanted).max()


def test_contacts_of_all_kinds_add(tmp_path: Path) -> None:
    traction = np.random.default_rng(0).normal(size=(5, 4, 3)) * 1e4
    np.save(tmp_path / "map.npy", traction)
    table = {"finger": "left", "file": "map.npy", "pitch_mm": 0.2, "path": [[0.0, 1.0], [0.2, 0.5]]}
    parts: dict[str, Any] = {"load": [LOAD], "contact": [SPHERE], "texture": [TEXTURE], "map": [table]}
    whole = values(made(tmp_path, **parts))
    single = [values(made(tmp_path, **{kind: entries})) for kind, entries in parts.items()]
    assert np.abs(whole - sum(single)).max() < 1e-13 * np.abs(whole).max()
    total = made(tmp_path, map=[table]).loads_at(0, np.array([0.1]))[0, 0]
    assert total[2:] == pytest.approx(0.75 * traction.sum((0, 1)) * 0.2e-3**2)
    assert not single[3][25:].any()  # after its last keyframe a map is gone
    np.save(tmp_path / "pressure.npy", traction[..., 2])
    flat = values(made(tmp_path, map=[{**table, "file": "pressure.npy"}]))
    traction[..., :2] = 0
    np.save(tmp_path / "map.npy", traction)
    assert np.array_equal(flat, values(made(tmp_path, map=[table])))


def test_indentation_twist_and_friction_come_through() -> None:
    sphere = {**SPHERE, "given": "indentation", "path": [[0.0, 0, 0, 0, 0, 0.05]]}
    force = made(contact=[sphere]).loads_at(0, np.array([0.1]))[0, 0, 4]
    assert force == pytest.approx(4 / 3 * 3.2e6 * np.sqrt(3e-3) * (5e-5) ** 1.5)
    twisted = {**SPHERE, "twist": True, "path": [[0.0, 0, 0, 0, 0, 0.5, 0.1]]}
    assert np.abs(values(made(contact=[twisted])) - values(made(contact=[SPHERE]))).max() > 0
    dragged = {**SPHERE, "friction": 0.3, "path": [[0.0, 0, 0, 5.0, 0, 0.5]]}
    assert made(contact=[dragged]).loads_at(0, np.array([0.1]))[0, 0, 2] == pytest.approx(0.15)


def test_every_effect_has_its_own_random_numbers() -> None:
    noise = {"read_noise": {"rms": 0.01}}
    one, both = made(load=[LOAD], effect=noise), made(load=[LOAD], effect={**noise, "drift": {"rate_per_s": 0.0}})
    assert [name for name, _ in both.effects] == ["drift", "read_noise"]  # the chain's order, not the file's
    without = made(load=[LOAD], effect={"drift": {"rate_per_s": 0.0}})
    plain = values(made(load=[LOAD]))
    assert np.abs((values(both) - values(without)) - (values(one) - plain)).max() < 1e-15
    other = made(load=[LOAD], effect=noise, seed=1)
    assert np.abs(values(other) - values(one)).max() > 1e-3


def test_very_many_loads_come_in_small_pieces(tmp_path: Path) -> None:
    np.save(tmp_path / "map.npy", np.ones((320, 320)))
    table = {"finger": "left", "file": "map.npy", "pitch_mm": 0.02, "path": [[0.0, 1.0]]}
    scene = made(tmp_path, map=[table])
    assert max(len(times) for _, times in scene.skin.chunks(0)) < 10
    got = values(scene)
    assert np.isfinite(got).all()
    assert got[0] == pytest.approx(got[29], rel=1e-12)


def test_loads_that_move_and_loads_that_stay_add() -> None:
    still = [{"finger": "left", "path": [[0.0, x, 0.1, 0.0, 0.1, 1.0]]} for x in (-1.0, 0.0, 0.5, 1.0, 1.5)]
    apart = values(made(load=[LOAD], duration_s=3.0)) + values(made(load=still, duration_s=3.0))
    both = values(made(load=[*still, LOAD], duration_s=3.0))
    assert np.abs(both - apart).max() < 1e-13 * np.abs(apart).max()


def test_extreme_scenes_are_numbers() -> None:
    every: dict[str, Any] = {name: {} for name in ORDER if name not in ("dead_taxels", "frame_timing")}
    for force in (0.0, 1e-12, 10.0):
        loads = [{"finger": "left", "path": [[0.0, 0.75, 0.75, 0, 0, force]]}]
        assert np.isfinite(values(made(load=loads, effect=every))).all()
    thin = tomllib.loads(SCENE)["finger"][0] | {"depth_mm": 1e-6}
    assert np.isfinite(values(made(load=[LOAD], finger=[thin]))).all()


def test_reading_again_gives_the_same_scene() -> None:
    for path in SCENES:
        one, other = read_scene(path), read_scene(path)
        assert one.effects == other.effects
        assert (one.title, one.frames, one.arrays, one.modulus) == (
            other.title,
            other.frames,
            other.arrays,
            other.modulus,
        )
