"""Scenes that are refused: what is wrong is named, all of it at once."""

import tomllib
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from cnnsim.support import InputError
from tactile.simulator.scene_file.file import scene_from
from tests.kits.touch.small_scene import LOAD, SPHERE, TEXTURE, made, values


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


def test_wrong_values_are_told_at_once_and_with_missing_keys() -> None:
    text = """
title = "wrong"
rate_hz = -5
duraton_s = 2.0
[cover]
youngs_modulus_mpa = -2
quantity = "pressure"
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
    told = str(raised.value)
    for what in (
        "unknown key 'duraton_s'",
        "no 'duration_s'",
        "rate_hz = -5.0",
        "youngs_modulus_mpa = -2.0",
        "quantity = 'pressure'",
        "finger 1: rows = 0",
        "load 1: finger = 'nobody'",
        "load 1: keyframe",
        "contact 1: keyframe 2",
        "[effect.read_noise]",
    ):
        assert told.count(what) == 1, what
    assert str(raised.value).count("wrong.toml") == 1
