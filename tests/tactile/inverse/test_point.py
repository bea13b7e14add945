"""Loads from the readings of a frame in one compiled call, against loads from the planes of the inverse."""

import numpy as np
import pytest

from tactile.core.frame import Quantity, TaxelArray
from tactile.elastic.halfspace import point_load_strain, point_load_stress
from tactile.inverse.localise import FrameFit, localise
from tactile.inverse.taxel import invert_strain, invert_stress
from tactile.inverse.weights import weigh
from tests.kits.touch.pads import as_row

MODULUS = 2.4e6


def array_of(shape: tuple[int, int], quantity: Quantity) -> TaxelArray:
    return TaxelArray("pad", *shape, 1e-3, 1.2e-3, quantity=quantity)


def signals(array: TaxelArray, load: list[float]) -> np.ndarray:
    if array.quantity == "strain":
        return point_load_strain(array.positions(), array.depth, [load], MODULUS)
    return point_load_stress(array.positions(), array.depth, [load])


@pytest.mark.parametrize("quantity", ["strain", "stress"])
@pytest.mark.parametrize("shape", [(2, 2), (8, 8), (20, 20)])
def test_readings_and_planes_give_the_same_load(shape: tuple[int, int], quantity: Quantity) -> None:
    """20 x 20 taxels are more than a block of the compiled inverse."""
    rng, array, answered = np.random.default_rng(5), array_of(shape, quantity), 0
    fit = FrameFit(array, MODULUS, 0.0)
    for n in range(10):
        half = np.array([array.cols, array.rows]) * array.pitch / 2
        values = signals(array, [*rng.uniform(-half, half), *rng.normal(0, 0.1, 2), rng.uniform(0.2, 1)])
        values = values + rng.normal(size=values.shape) * 1e-3 * np.abs(values).max()
        if n % 3 == 0:
            values[rng.integers(shape[0]), rng.integers(shape[1])] = np.nan
        x, y, z = np.moveaxis(values, -1, 0)
        planes = [invert_stress(x, y, z, array.depth, 0.0)]
        if quantity == "strain":
            planes = [invert_strain(x, y, z, array.depth, MODULUS, 0.0, sign) for sign in (1, -1)]
        load = fit(values, weigh(None, shape))
        if load is not None:
            answered += 1
            by_planes = localise(array.positions(), planes[0], planes[1] if quantity == "strain" else None, array.depth)
            assert as_row(load) == pytest.approx(as_row(by_planes), rel=1e-9, abs=1e-12)
            assert load.sigma == pytest.approx(by_planes.sigma, rel=1e-6)
            assert (load.validity, load.left_out) == (by_planes.validity, by_planes.left_out)
    assert answered >= 6
