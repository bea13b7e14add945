"""Transforms of traction maps against the direct sum."""

import numpy as np
import pytest

from cnnsim.support import InputError
from tactile.core.frame import TaxelArray
from tactile.elastic.medium import Medium
from tactile.elastic.sums.direct import direct_sum
from tactile.elastic.sums.spectral import TractionTransform, grid_sum, map_loads

random = np.random.default_rng(5)


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


def test_maps_on_the_grid_of_large_arrays_are_summed_by_transforms() -> None:
    medium, at = Medium(2.4e6, 0.48), TaxelArray("a", 26, 26, 1e-3, 1.3e-3).positions()
    loads = np.empty((3, 30 * 28, 5))
    grid = np.stack(np.meshgrid(np.arange(30), np.arange(28)), axis=-1).reshape(-1, 2) * 1e-3
    loads[..., :2], loads[..., 2:] = grid + at[0, 0] + (0.2e-3, -4.3e-3), random.normal(size=(3, 840, 3))
    direct, felt = direct_sum(at, 1.3e-3, loads, medium), grid_sum(at, 1.3e-3, loads, medium)
    assert felt is not None
    assert np.abs(direct - felt).max() < 1e-10 * np.abs(direct).max()
    moving, off_grid = loads.copy(), loads.copy()
    moving[1, 3, 0] += 1e-3
    off_grid[:, 3, 0] += 1e-4
    for others in (moving, off_grid, loads[:, :500]):
        assert grid_sum(at, 1.3e-3, others, medium) is None
    assert grid_sum(at[:8, :8], 1.3e-3, loads, medium) is None


def test_wrong_maps_are_refused() -> None:
    transform = TractionTransform((3, 4), (2, 2), 1e-3, 1e-3, Medium(1.0))
    with pytest.raises(InputError, match=r"\(4, 3, 3\), \(3, 4, 3\) wanted"):
        transform(np.zeros((4, 3, 3)))
    with pytest.raises(InputError, match="not finite"):
        transform(np.full((3, 4, 3), np.nan))
    with pytest.raises(InputError, match="positive"):
        TractionTransform((0, 4), (2, 2), 1e-3, 1e-3, Medium(1.0))
