"""What a layer adds under point loads, compiled, against the same in NumPy."""

import numpy as np
import pytest

from tactile.elastic.medium import FieldQuantity, Medium
from tactile.elastic.sums.layer_sum import add_layer_term
from tests.oracles.elastic.layer import layer_term


@pytest.mark.parametrize("quantity", ("strain", "stress"))
@pytest.mark.parametrize("thickness", (1.0, 2.5, 60.0))
def test_compiled_it_is_the_same(thickness: float, quantity: FieldQuantity) -> None:
    random, medium, depth = np.random.default_rng(3), Medium(2e6, 0.4, quantity, thickness * 1e-3), 1e-3
    at = random.uniform(-0.04, 0.04, (20, 2))
    loads = random.normal(size=(3, 50, 5)) * (0.02, 0.02, 1, 1, 1)
    loads[0, 0, :2], loads[1, 3, 2:] = at[0], 0.0  # right above a taxel; nothing
    wanted = layer_term(at, depth, loads[:, None], medium.thickness, medium)
    out = wanted.copy()
    add_layer_term(out, at, depth, loads, medium)
    assert np.abs(out - 2 * wanted).max() < 1e-12 * np.abs(wanted).max()  # it is added
    reached = np.hypot(*(at[:, None] - loads[0, None, :, :2]).transpose(2, 0, 1)) < 30 * medium.thickness
    assert reached.any()
    assert reached.all() == (thickness == 60)  # loads that a thin layer does not feel are among them
