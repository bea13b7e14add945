"""Bodies as height maps: against the exact laws of round bodies, on half-space and layer, and from STL files."""

from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

from cnnsim.support import InputError
from tactile.elastic.medium import Medium
from tactile.elastic.rough_contact import RoughContact
from tactile.simulator.contacts.height_map import HeightMap
from tactile.simulator.contacts.heights import cast_heights, read_heights, read_stl
from tactile.simulator.contacts.indenter import Indenter
from tactile.simulator.contacts.moving_contact import MovingContact
from tactile.simulator.contacts.rig import Rig
from tactile.simulator.field import field_at
from tactile.simulator.scene_file.file import scene_from

R, SIDE = 5e-3, 41
PITCH = 4e-3 / SIDE
STEPS = (np.arange(SIDE) - SIDE // 2) * PITCH
BALL = (STEPS[None] ** 2 + STEPS[:, None] ** 2) / 2 / R


@pytest.mark.parametrize("thickness", (np.inf, 1.2e-3))
def test_a_ball_is_hertz_or_the_layers_law(thickness: float) -> None:
    medium, ball = Medium(2.4e6, thickness=thickness), Indenter("sphere", R)
    contact = RoughContact(BALL, PITCH, medium)
    for depth, bound in ((3e-5, 1e-2), (2e-4, 3e-3)):  # four and ten cells in a radius
        pressure = contact.pressed(depth)
        wanted = ball.force_at(np.array([depth]), medium)[0]
        assert pressure.sum() * PITCH**2 == pytest.approx(wanted, rel=bound)
        assert pressure.min() == 0
        left = depth - BALL - contact.sunk(pressure)  # the gap: closed where it presses, open elsewhere
        assert np.abs(left[pressure > 0]).max() < 2e-6 * depth
        assert left.max() < 2e-6 * depth
    at = np.array([[0.0, 0.0], [7e-4, 2e-4], [1.5e-3, 0.0]])
    path = [(0.0, 1e-4, 0, 0.05, -0.02, 0.5)]
    mapped = HeightMap(0, BALL, PITCH, np.array(path)).loads(np.zeros(1), 1e-3, medium)
    smooth = MovingContact(0, ball, np.array(path)).loads(np.zeros(1), 1e-3, medium)
    felt, known = (field_at(at, 1e-3, loads, medium)[0] for loads in (mapped, smooth))
    assert np.abs(felt - known).max() < 5e-3 * np.abs(known).max()


def test_a_height_map_moves_slips_lifts_and_is_held() -> None:
    medium, times = Medium(2.4e6), np.linspace(0, 2, 5)
    path = np.array([(0.0, 0, 0, 0.5, 0, 0.5), (1.0, 1e-3, 0, 0, 0, -0.5), (2.0, 1e-3, 0, 0, 0, 0.5)])
    body = HeightMap(0, BALL, PITCH, path, 0.3)
    totals = body.loads(times, 1e-3, medium).totals[:, 0]
    assert totals[:, 4] == pytest.approx((0.5, 0, 0, 0, 0.5), abs=1e-12)
    assert totals[0, 2] == pytest.approx(0.15)
    assert totals[:, 0] == pytest.approx((0, 5e-4, 1e-3, 1e-3, 1e-3))
    raised = Rig().with_move(lambda places: (np.zeros_like(places), np.full(len(places), 1e-6)), 50e-6)
    grown = body.loads(times, 1e-3, medium, raised).totals[0, 0, 4] / 0.5
    ball = Indenter("sphere", R).held_factor(np.array([0.5]), np.array([1e-6]), medium, 0.0)[0]
    assert grown - 1 == pytest.approx(ball - 1, rel=0.05)
    deep = HeightMap(0, BALL, PITCH, np.array([(0.0, 0, 0, 0, 0, 1e-4)]), None, True)
    force = Indenter("sphere", R).force_at(np.array([1e-4]), medium)[0]
    assert deep.loads(np.zeros(1), 1e-3, medium).totals[0, 0, 4] == pytest.approx(force, rel=0.02)
    with pytest.raises(InputError, match="at most half the depth wanted"):
        body.loads(times, 1e-4, medium)
    through = HeightMap(0, BALL, PITCH, np.array([(0.0, 0, 0, 0, 0, 3e-3)]), None, True)
    with pytest.raises(InputError, match=r"into a cover of 1\.2 mm; less than its thickness wanted"):
        through.loads(np.zeros(1), 1e-3, Medium(2.4e6, thickness=1.2e-3))


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
    with pytest.raises(InputError, match=r"contact 1: radius_mm of a height_map; file and pitch_mm wanted"):
        scene_from({**table, "contact": [{**contact, "radius_mm": 1.0}]}, "here", tmp_path)
