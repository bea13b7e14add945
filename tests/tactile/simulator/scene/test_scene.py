"""Simulated sources: a scene samples the half-space."""

import zlib
from dataclasses import replace
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest

from cnnsim.support import InputError
from tactile.elastic.halfspace import point_load_strain, point_load_stress
from tactile.inverse.localise import localise
from tactile.inverse.taxel import invert_strain
from tactile.simulator.scene_file.file import read_scene, scene_from
from tests.kits.touch.random_scenes import needle
from tests.kits.touch.source import GRIP, parsed


def test_scene_samples_the_half_space() -> None:
    scene = scene_from(parsed(), "here")
    frames = list(scene)
    assert scene.frames == len(frames) == 10
    assert [frame.t for frame in frames] == [k / 100 for k in range(10)]
    assert scene.modulus == 2.4e6
    assert frames[0].values.shape == (2, 3, 3)
    for k in (0, 1, 7, 8, 9):
        assert not frames[k].values.any()  # before the first keyframe and after the last
    middle = [(0.2e-3, -0.4e-3, 0.1, 0, 1.5)]
    at = scene.arrays[0].positions()
    assert frames[4].values == pytest.approx(point_load_strain(at, 1.5e-3, middle, 2.4e6), rel=1e-12)
    stress = scene_from(parsed(cover={"youngs_modulus_mpa": 2.4, "quantity": "stress"}), "here")
    assert list(stress)[4].values == pytest.approx(point_load_stress(at, 1.5e-3, middle), rel=1e-12)


def test_loads_add_and_one_keyframe_stays() -> None:
    load = {"finger": "left", "path": [[0.05, 0.3, 0, 0, 0, 1]]}
    alone = list(scene_from(parsed(load=[load]), "here"))
    assert [bool(frame.values.any()) for frame in alone] == [False] * 5 + [True] * 5
    twice = list(scene_from(parsed(load=[load, load]), "here"))
    assert twice[7].values == pytest.approx(2 * alone[7].values)


def test_grip_scene_is_in_time_order_and_its_loads_are_found() -> None:
    scene = read_scene(GRIP)
    frames = list(scene)
    assert len(frames) == scene.frames == 2 * 1200
    assert [frame.finger for frame in frames] == [0, 1] * 1200
    assert all(a.t <= b.t for a, b in pairwise(frames))
    for array in scene.arrays:
        assert array.pitch < (1 + np.sqrt(2)) / 2 * array.depth  # eq. (12)
    for frame in frames[500:900:7]:
        array = scene.arrays[frame.finger]
        wanted = scene.loads_at(frame.finger, np.array([frame.t]))[0, 0]
        x, y, z = np.moveaxis(frame.values, -1, 0)
        pressing, pulling = (invert_strain(x, y, z, array.depth, scene.modulus, 0.0, p) for p in (1, -1))
        load = localise(array.positions(), pressing, pulling, array.depth)
        assert (load.x, load.y, load.Q, load.R, load.F) == pytest.approx(tuple(wanted), rel=1e-9, abs=1e-12)


def test_unreadable_scenes_are_refused(tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"nothing\.toml"):
        read_scene(tmp_path / "nothing.toml")
    (tmp_path / "bad.toml").write_text("title = ")
    with pytest.raises(InputError, match=r"bad\.toml: not TOML: Invalid value"):
        read_scene(tmp_path / "bad.toml")


@pytest.mark.parametrize("seed", (0, 7, 2**32 - 1, 2**32, 2**70))
def test_effects_draw_from_generators_of_seed_finger_and_name(seed: int) -> None:
    scene = replace(needle(), seed=seed)
    given = np.random.default_rng((seed, 3, zlib.crc32(b"read_noise")))
    assert np.array_equal(scene.random("read_noise", 3).random(4), given.random(4))
