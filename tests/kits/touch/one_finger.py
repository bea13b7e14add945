"""A scene of one finger with a moving load, and the command `tactile run`."""

from pathlib import Path
from typing import Any

from click.testing import CliRunner, Result

from tactile.cli.group import main

SCENE = """
title = "one finger"
rate_hz = 100
duration_s = 2.0
[cover]
youngs_modulus_mpa = 2.4
quantity = "{quantity}"
[[finger]]
name = "tip"
rows = 3
cols = 3
pitch_mm = 1.0
depth_mm = 1.0
origin_mm = [0.0, 0.0]
[[load]]
finger = "tip"
path = [[0.5, -0.3, 0.2, 0.0, 0.0, 0.5], [1.0, -0.3, 0.2, 0.1, -0.3, 0.5], [1.5, 0.4, 0.2, 0.1, -0.3, 0.5]]
"""


def run_command(*arguments: Any) -> Result:
    """Return the result of `tactile run` with these arguments."""
    return CliRunner().invoke(main, ["run", *(str(argument) for argument in arguments)])


def write_scene(tmp_path: Path, quantity: str = "strain") -> Path:
    """Write the scene and return its path."""
    path = tmp_path / "scene.toml"
    path.write_text(SCENE.format(quantity=quantity), encoding="utf-8")
    return path
