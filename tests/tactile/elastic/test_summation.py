"""Three methods of summation, one number: direct sum, influence matrix, transforms of traction maps."""

import numpy as np
import pytest

from cnnsim.support import InputError
from tactile.core.frame import TaxelArray
from tactile.elastic.medium import Felt, Medium
from tactile.elastic.sums.cells import point_cell, uniform_cell
from tactile.elastic.sums.direct import direct_sum
from tactile.elastic.sums.influence import Influence
from tactile.elastic.sums.spectral import TractionTransform, map_loads
from tactile.simulator.summation import Name, Summation, choose_method, sum_loads

random = np.random.default_rng(5)


@pytest.mark.parametrize(("nu", "quantity"), [(0.0, "strain"), (0.5, "strain"), (0.4, "stress")])
def test_matrix_is_the_direct_sum(nu: float, quantity: Felt) -> None:
    medium, at = Medium(2.4e6, nu, quantity), random.uniform(-5e-3, 5e-3, (8, 8, 2))
    loads = np.empty((50, 9, 5))
    loads[..., :2], loads[..., 2:] = random.uniform(-5e-3, 5e-3, (9, 2)), random.normal(size=(50, 9, 3))
    wanted = direct_sum(at, 1e-3, loads, medium)
    got = Influence(at, 1e-3, loads[0, :, :2], medium)(loads[..., 2:])
    assert np.abs(got - wanted).max() < 1e-13 * np.abs(wanted).max()


@pytest.mark.parametrize("offset", [(0.0, 0.0), (0.37e-3, -2.11e-3)])
@pytest.mark.parametrize(("cells", "taxels"), [((24, 31), (17, 40)), ((1, 5), (3, 1)), ((50, 50), (50, 50))])
def test_transforms_are_the_direct_sum(
    cells: tuple[int, int], taxels: tuple[int, int], offset: tuple[float, float]
) -> None:
    pitch, depth, medium = 0.5e-3, 0.7e-3, Medium(2.4e6, 0.45)
    traction = random.normal(size=(*cells, 3))
    at = np.stack(np.meshgrid(np.arange(taxels[1]), np.arange(taxels[0])), axis=-1) * pitch + offset
    wanted = direct_sum(at, depth, map_loads(traction, pitch, (0.0, 0.0))[None], medium)[0]
    got = TractionTransform(cells, taxels, pitch, depth, medium, offset)(traction)
    assert np.abs(got - wanted).max() < 1e-10 * np.abs(wanted).max()


def test_three_methods_one_number() -> None:
    array = TaxelArray("a", 26, 26, 1e-3, 1.3e-3)
    medium, corner = Medium(2.4e6, 0.48), array.positions()[0, 0]
    loads = np.empty((3, 30 * 28, 5))
    grid = np.stack(np.meshgrid(np.arange(30), np.arange(28)), axis=-1).reshape(-1, 2) * 1e-3
    loads[..., :2], loads[..., 2:] = grid + corner + (0.2e-3, -4.3e-3), random.normal(size=(3, 840, 3))
    at = array.positions()
    direct, matrix, fft = (
        sum_loads(Summation(name, ""), at, array.depth, loads, medium) for name in ("direct", "matrix", "fft")
    )
    largest = np.abs(direct).max()
    assert np.abs(direct - matrix).max() < 1e-13 * largest
    assert np.abs(direct - fft).max() < 1e-10 * largest
    assert choose_method(array, loads, 3).name == "fft"


def test_the_plan_looks_at_the_task() -> None:
    array = TaxelArray("a", 8, 8, 1e-3, 1e-3)
    still = np.zeros((4, 20, 5)) + random.uniform(0, 1e-3, (20, 5))
    moving = still.copy()
    moving[1, 3, 0] += 1e-4
    assert choose_method(array, still, 1000).name == "matrix"
    assert choose_method(array, still, 10).name == "direct"
    assert choose_method(array, moving, 1000).name == "direct"
    assert choose_method(array, still[:, :2], 1000).name == "direct"
    names: tuple[Name, ...] = ("matrix", "fft")
    for name in names:
        with pytest.raises(InputError, match="loads that move"):
            sum_loads(Summation(name, ""), array.positions(), 1e-3, moving, Medium(1.0))
    with pytest.raises(InputError, match="share no grid"):
        sum_loads(Summation("fft", ""), array.positions(), 1e-3, still, Medium(1.0))


def test_an_even_cell_is_many_points() -> None:
    medium, pitch = Medium(2.0, 0.3), 0.5
    nodes, weights = np.polynomial.legendre.leggauss(40)
    at = random.uniform(-1, 1, (6, 2))
    steps = np.stack(np.meshgrid(nodes, nodes), axis=-1).reshape(-1, 2) * pitch / 2
    over = np.outer(weights, weights).ravel() / 4
    for depth, x, y in ((0.1, at[:, 0], at[:, 1]), (1.0, at[:, 0] * 3, at[:, 1] * 3)):
        many = point_cell(x[:, None] - steps[:, 0], y[:, None] - steps[:, 1], depth, pitch, medium)
        wanted = np.einsum("apij,p->aij", many, over)
        got = uniform_cell(x, y, depth, pitch, medium)
        assert np.abs(got - wanted).max() < 1e-6 * np.abs(wanted).max()


def test_even_cells_carry_their_traction_at_any_depth() -> None:
    # right under the surface the stress is minus the traction on the cell and nothing beside it
    felt = uniform_cell([0.0, 0.1, 1.2], [0.0, -0.2, 0.0], 1e-6, 1.0, Medium(1.0, quantity="stress"))
    assert felt[:2] == pytest.approx(-np.stack([np.eye(3)] * 2), abs=1e-4)
    assert felt[2] == pytest.approx(np.zeros((3, 3)), abs=1e-4)


def test_wrong_maps_are_refused() -> None:
    transform = TractionTransform((3, 4), (2, 2), 1e-3, 1e-3, Medium(1.0))
    with pytest.raises(InputError, match=r"\(4, 3, 3\), \(3, 4, 3\) wanted"):
        transform(np.zeros((4, 3, 3)))
    with pytest.raises(InputError, match="not finite"):
        transform(np.full((3, 4, 3), np.nan))
    with pytest.raises(InputError, match="cell 'round'"):
        TractionTransform((3, 4), (2, 2), 1e-3, 1e-3, Medium(1.0), cell="round")
    with pytest.raises(InputError, match="positive"):
        TractionTransform((0, 4), (2, 2), 1e-3, 1e-3, Medium(1.0))
    matrix = Influence(np.zeros((2, 2)), 1e-3, np.zeros((4, 2)), Medium(1.0))
    with pytest.raises(InputError, match=r"\(frames, 4, 3\)"):
        matrix(np.zeros((5, 3, 3)))
    with pytest.raises(InputError, match="places"):
        Influence(np.zeros((2, 2)), 1e-3, np.zeros((4, 3)), Medium(1.0))
