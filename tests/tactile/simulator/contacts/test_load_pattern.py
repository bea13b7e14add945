"""Fields of height maps over frames: equivalent points and all cells, moving and at rest, against the sum of loads."""

from dataclasses import replace

import numpy as np
import pytest

from tactile.elastic.medium import Medium
from tactile.simulator.contacts.height_map import HeightMap
from tactile.simulator.contacts.pressed_map import BETWEEN
from tactile.simulator.summation import field_at
from tests.oracles.elastic.layer import layered_load

DEPTH, PITCH = 1e-3, 1.5e-4
X, Y = np.meshgrid((np.arange(23) - 11) * PITCH, (np.arange(19) - 9) * PITCH)
DENTED = (X**2 + 2 * Y**2) / 0.05 + 3e-5 * np.exp(-((X - 2e-4) ** 2 + Y**2) / (4e-4) ** 2)
AT = np.stack(np.meshgrid((np.arange(4) - 1.5) * 8e-4, (np.arange(3) - 1) * 8e-4), axis=-1)


def body(moves: bool, pull: float = 0.05, friction: float | None = None) -> HeightMap:
    away = 2e-3 if moves else 0.0
    path = [(0.0, -away, 0, pull, 0, -1e-5), (1.0, away, away / 3, 0, pull, 8e-5), (1.9, 0, 0, 0, -pull, 4e-5)]
    return HeightMap(0, DENTED, PITCH, np.array(path), friction, True)


@pytest.mark.parametrize("thickness", (np.inf, 2e-3))
@pytest.mark.parametrize(("moves", "pull", "frames"), ((True, 0.05, 40), (False, 0.05, 90)))
def test_points_and_cells_give_the_field_of_all_cells(moves: bool, pull: float, frames: int, thickness: float) -> None:
    medium, times = Medium(2e6, 0.45, thickness=thickness), np.linspace(0, 2, frames)
    one = body(moves, pull)
    loads, solved = one.loads(times, DEPTH, medium), one.pressed(medium)
    totals = loads.totals[:, 0]
    wanted = []
    for x, y, q, r, force in totals[:: frames // 20]:  # pressures straight in the force between those of two levels
        cells = np.array([np.interp(force, solved.force[::BETWEEN], column) for column in solved.forces.T])
        share = cells / cells.sum() if force > 0 else np.zeros(len(cells))
        rows = np.column_stack([solved.places + np.array([x, y]), share[:, None] * (q, r, force)])
        wanted.append(layered_load(AT, DEPTH, rows, medium))
    peak = np.abs(wanted).max()
    assert totals[:, 4].min() == 0 < totals[:, 4].max()
    for accuracy, bound in ((1e-3, 1e-3), (1e-4, 1e-4), (0.0, 1e-12 if np.isinf(thickness) else 1e-7)):
        felt = field_at(AT, DEPTH, loads, medium, accuracy=accuracy)[:: frames // 20]
        assert np.abs(felt - wanted).max() <= bound * peak
    stress = replace(medium, quantity="stress", modulus=2e6)
    felt = field_at(AT, DEPTH, loads, stress)
    assert np.abs(felt - field_at(AT, DEPTH, loads, stress, accuracy=0.0)).max() <= 1e-4 * np.abs(felt).max()
