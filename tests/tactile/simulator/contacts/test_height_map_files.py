"""Bodies as height maps from files: STL, and scenes that name them."""

import re
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

from cnnsim.support import InputError
from tactile.elastic.medium import Medium
from tactile.simulator.contacts.heights import cast_heights, read_heights, read_stl
from tactile.simulator.contacts.indenter import Indenter
from tactile.simulator.explain import explain
from tactile.simulator.scene_file.file import scene_from
from tests.tactile.simulator.contacts.test_height_map import BALL, PITCH, R


def pyramid() -> NDArray[np.float64]:
    """A tip down at (0, 0, 0), a square of 2 by 2 at height 1, and a lid over it."""
    square = np.array([(-1, -1, 1), (1, -1, 1), (1, 1, 1), (-1, 1, 1)], float)
    sides = [(np.zeros(3), square[k], square[(k + 1) % 4]) for k in range(4)]
    return np.array([*sides, square[:3], square[[0, 2, 3]]])


def test_stl_files_are_cast_from_below(tmp_path: Path) -> None:
    triangles = pyramid()
    binary = np.zeros(len(triangles), np.dtype([("n", "<f4", 3), ("at", "<f4", (3, 3)), ("more", "<u2")]))
    binary["at"] = triangles
    (tmp_path / "b.stl").write_bytes(bytes(80) + len(triangles).to_bytes(4, "little") + binary.tobytes())
    corners = "\n".join(f"vertex {x} {y} {z}" for x, y, z in triangles.reshape(-1, 3))
    (tmp_path / "t.STL").write_text(f"solid p\n{corners}\nendsolid p\n")
    for name in ("b.stl", "t.STL"):
        assert read_stl(tmp_path / name) == pytest.approx(triangles)
    heights = read_heights(tmp_path / "b.stl", 1e-4)
    assert heights.shape == (20, 20)
    x = (np.arange(20) - 9.5) * 0.1
    wanted = np.maximum(np.abs(x)[None], np.abs(x)[:, None]) * 1e-3
    assert heights == pytest.approx(wanted, abs=1e-9)
    disc = cast_heights(np.array([[(0, 0, 0), (1, 0, 0), (0, 1, 0)]], float), 0.1)
    assert disc[9, 9] >= 1  # beyond the outline: out of reach
    (tmp_path / "bad.stl").write_text("solid\nvertex 1 2\n")
    for bad, message in (("bad.stl", "no STL file|no triangles"), ("none.npy", "cannot be read")):
        with pytest.raises(InputError, match=message):
            read_heights(tmp_path / bad, 1e-4)


def test_a_scene_takes_a_height_map(tmp_path: Path) -> None:
    np.save(tmp_path / "ball.npy", BALL * 1e3)
    contact = {
        "finger": "f",
        "shape": "height_map",
        "file": "ball.npy",
        "pitch_mm": PITCH * 1e3,
        "path": [[0, 0, 0, 0, 0, 0.2]],
    }
    finger = {"name": "f", "rows": 2, "cols": 2, "pitch_mm": 1.0, "depth_mm": 1.0}
    table = {
        "title": "t", "rate_hz": 10, "duration_s": 0.3, "cover": {"youngs_modulus_mpa": 2.4}, "finger": [finger],
        "contact": [contact],
    }  # fmt: skip
    frames = list(scene_from(table, "here", tmp_path))
    assert len(frames) == 3
    assert frames[0].values[..., 2].max() < 0
    told = explain(scene_from(table, "here", tmp_path))
    width = re.match(r"height map on f: contact (.*) mm wide on cells of 0.0976 mm, its force known to", told.lines[1])
    assert width
    hertz = 2e3 * Indenter("sphere", R).contact_radius(np.array(0.2), Medium(2.4e6))
    assert float(width[1]) == pytest.approx(hertz, rel=0.05)
    np.save(tmp_path / "ball.npy", np.sqrt(np.arange(16) + np.arange(16)[:, None]))  # a corner that no cell shows
    coarse = scene_from({**table, "contact": [{**contact, "pitch_mm": 0.5}]}, "here", tmp_path)
    assert "leave its force open by" in coarse.range_notes[0]
    assert explain(coarse).notes == coarse.range_notes
    with pytest.raises(InputError, match=r"contact 1: radius_mm of a height_map; file and pitch_mm wanted"):
        scene_from({**table, "contact": [{**contact, "radius_mm": 1.0}]}, "here", tmp_path)
