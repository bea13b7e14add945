"""Scenes: what a file names is computed, what it does not name is not even imported, what is wrong is refused."""

import copy
import subprocess
import sys
import tomllib
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from cnnsim.support import InputError
from tactile.elastic.halfspace import point_load_strain
from tactile.simulator.effects import ORDER
from tactile.simulator.scene.file import read_scene, scene_from
from tactile.sources import open_source
from tests.kits.paths import ROOT

SCENES = sorted((ROOT / "examples" / "scenes").glob("*.toml"))
SCENE = """
title = "t"
rate_hz = 100
duration_s = 0.3
[cover]
youngs_modulus_mpa = 2.4
[[finger]]
name = "left"
rows = 2
cols = 3
pitch_mm = 1.5
depth_mm = 1.5
"""
LOAD = {"finger": "left", "path": [[0.0, 0.0, 0.0, 0.1, 0.0, 1.0], [0.3, 0.4, -0.8, 0.2, 0.0, 2.0]]}
SPHERE = {"finger": "left", "shape": "sphere", "radius_mm": 3, "path": [[0.0, 0, 0, 0, 0, 0.5]]}
TEXTURE = {"finger": "left", "material": "rasp", "stop_s": 0.3, "speed_mm_s": 5, "force_N": 0.3}


def made(folder: Path = Path(), **changes: Any) -> Any:
    return scene_from({**copy.deepcopy(tomllib.loads(SCENE)), **changes}, "here", folder)


def values(scene: Any, finger: int = 0) -> Any:
    return np.concatenate([batch.values for batch in scene.batches(finger)])


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
        ("[effect.read_noise]\nrms = 0.1\n", "effects.read_noise"),
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
    unnamed = {f"scene.{name}" for name in ("auto", "explain", "estimate", "contact_tables")}
    unnamed |= {f"contacts.{name}" for name in ("sliding_texture", "materials", "traction_map")}
    unnamed |= {f"tactile.elastic.{name}" for name in ("discs", "lines", "influence", "spectral")}
    if "finite_thickness" in extra:  # a point on a layer is a circle of radius 0 in its table
        unnamed.remove("tactile.elastic.discs")
    assert not loaded & unnamed
    assert ("tactile.elastic.unit_disc" in loaded) == (module == "effects.finite_thickness")
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
    assert max(len(times) for _, times in scene.pieces(0)) < 10
    got = values(scene)
    assert np.isfinite(got).all()
    assert got[0] == pytest.approx(got[29], rel=1e-12)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"effects": "all"}, "effects = 'all', 'auto' wanted"),
        ({"tolerance": 0.1}, "a tolerance without effects"),
        ({"seed": -1}, "seed = -1"),
        ({"effect": {"read_nois": {}}}, r"\[effect\]: unknown key 'read_nois'; did you mean 'read_noise'"),
        ({"effect": {"read_noise": {"rma": 1}}}, r"\[effect.read_noise\]: unknown key 'rma'; did you mean 'rms'"),
        ({"effect": {"read_noise": 3}}, r"read_noise\]: 3, a table wanted"),
        ({"contacts": []}, "unknown key 'contacts'; did you mean 'contact'"),
        ({"contact": [{**SPHERE, "shape": "spere"}]}, "contact 1: shape 'spere', one of point"),
        ({"contact": [{**SPHERE, "radius": 1}]}, "contact 1: unknown key 'radius'; did you mean 'radius_mm'"),
        ({"contact": [{**SPHERE, "radius_mm": 0}]}, "contact 1: a sphere of radius 0.0"),
        ({"contact": [{**SPHERE, "given": "depth"}]}, "given = 'depth', 'force' or 'indentation'"),
        ({"contact": [{**SPHERE, "twist": 1}]}, "twist = 1, true or false"),
        ({"contact": [{**SPHERE, "twist": True}]}, "M_Nmm.*a list of 7"),
        ({"contact": [{**SPHERE, "shape": "point", "twist": True}]}, "a twisted point"),
        ({"contact": [{**SPHERE, "shape": "disc", "given": "indentation"}]}, "indentation given for a disc"),
        ({"contact": [{**SPHERE, "friction": -1}]}, "friction = -1.0"),
        ({"contact": [{**SPHERE, "finger": "right"}]}, "finger = 'right', one of left"),
        ({"texture": [{**TEXTURE, "material": "resp"}]}, "material: unknown key 'resp'; did you mean 'rasp'"),
        ({"texture": [{**TEXTURE, "stop_s": 0.0}]}, "texture 1: object drawn from 0.0 to 0.0 s"),
        ({"texture": [{**TEXTURE, "speed_mms": 1}]}, "did you mean 'speed_mm_s'"),
        ({"map": [{"finger": "left", "file": "no.npy", "pitch_mm": 1, "path": [[0, 1]]}]}, r"map 1: .*no\.npy"),
        ({"cover": {"youngs_modulus_mpa": 1, "full_scale": 0}}, "full_scale = 0.0, a positive"),
        ({"load": []}, "without loads"),
    ],
)
def test_wrong_scenes_are_refused(change: dict[str, Any], message: str) -> None:
    with pytest.raises(InputError, match=message) as caught:
        made(**{"load": [LOAD], **change})
    assert str(caught.value).startswith("here")


def test_wrong_maps_and_too_wide_contacts_are_refused(tmp_path: Path) -> None:
    table = {"finger": "left", "file": "map.npy", "pitch_mm": 0.2, "path": [[0.0, 1.0]]}
    for wrong in (np.zeros(3), np.full((2, 2), np.nan), np.zeros((2, 2, 4)), np.zeros((0, 2))):
        np.save(tmp_path / "map.npy", wrong)
        with pytest.raises(InputError, match=r"map 1: .*wanted"):
            made(tmp_path, map=[table])
    with pytest.raises(InputError, match="at most 100 wanted"):
        values(made(contact=[{**SPHERE, "shape": "disc", "radius_mm": 1e4}]))


def test_methods_are_chosen_and_changed_freely() -> None:
    still = [{"finger": "left", "path": [[0.0, x, 0.1, 0.0, 0.1, 1.0]]} for x in (-1.0, 0.0, 0.5, 1.0, 1.5)]
    scene = made(load=still, duration_s=3.0)
    assert scene.method(0).name == "matrix"
    moving = made(load=[*still, LOAD], duration_s=3.0)
    assert moving.method(0).name == "direct"
    apart = values(made(load=[LOAD], duration_s=3.0)) + values(scene)
    assert np.abs(values(moving) - apart).max() < 1e-13 * np.abs(apart).max()


def test_extreme_scenes_are_numbers() -> None:
    for force in (0.0, 1e-12, 1e6):
        loads = [{"finger": "left", "path": [[0.0, 0.75, 0.75, 0, 0, force]]}]
        every: dict[str, Any] = {name: {} for name in ORDER if name not in ("dead_taxels", "frame_timing")}
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


def test_wrong_values_are_told_at_once_and_with_missing_keys() -> None:
    text = """
title = "wrong"
rate_hz = -5
duraton_s = 2.0
dtype = "float16"
[cover]
youngs_modulus_mpa = -2
quantity = "force"
[[finger]]
name = "a"
rows = 0
cols = 2
pitch_mm = 1
depth_mm = 1
[[load]]
finger = "nobody"
path = [[0, 0, 0]]
[[contact]]
finger = "a"
shape = "sphere"
radius_mm = -1
path = [[1, 0, 0, 0, 0, 0], [0, 0, 0, 0, 0, 0]]
[effect.read_noise]
rms = -1
"""
    with pytest.raises(InputError) as raised:
        scene_from(tomllib.loads(text), "wrong.toml")
    told = str(raised.value).split("; ")
    for what in (
        "unknown key 'duraton_s'",
        "no 'duration_s'",
        "rate_hz = -5.0",
        "cpu in float16",
        "youngs_modulus_mpa = -2.0",
        "quantity = 'force'",
        "0 x 2 taxels",
        "finger = 'nobody'",
        "load 1: keyframe",
        "contact 1: keyframe 2",
        "[effect.read_noise]",
    ):
        assert sum(what in one for one in told) == 1, what
    assert str(raised.value).count("wrong.toml") == 1
