"""A small scene for tests of sources."""

import copy
import tomllib
from typing import Any

from tests.kits.paths import ROOT

GRIP = ROOT / "examples" / "scenes" / "grip.toml"

SCENE = """
title = "t"
rate_hz = 100
duration_s = 0.1
[cover]
youngs_modulus_mpa = 2.4
[[finger]]
name = "left"
rows = 2
cols = 3
pitch_mm = 1.5
depth_mm = 1.5
[[load]]
finger = "left"
path = [[0.02, 0, 0, 0, 0, 1.0], [0.06, 0.4, -0.8, 0.2, 0, 2.0]]
"""


def parsed(**changes: Any) -> dict[str, Any]:
    return {**copy.deepcopy(tomllib.loads(SCENE)), **changes}
