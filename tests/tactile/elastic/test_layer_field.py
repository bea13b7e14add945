"""Polynomials of the field on a layer: against the half-space and the layer's own integrals, both in newtons."""

import numpy as np
import pytest

from cnnsim.support import InputError
from tactile.elastic.layer_field import HALF_SPACE, PARTS, layer_field
from tactile.elastic.medium import FieldQuantity, Medium
from tests.oracles.elastic.layer import layer_load

DEPTH, MODULUS = 1.3e-3, 2e6


@pytest.mark.parametrize("quantity", ["strain", "stress"])
@pytest.mark.parametrize("thickness", [1.0, 4.0, 100.0])
def test_the_field_is_that_of_the_integrals(thickness: float, quantity: FieldQuantity) -> None:
    random, (q, r, f) = np.random.default_rng(3), (0.3, -0.7, 1.1)
    at = random.normal(size=(200, 2)) * random.choice([0.01, 0.5, 2, 6], size=(200, 1))
    at[0] = 0.0
    x, y = at.T
    along = PARTS / np.sqrt(1 + x * x + y * y)
    part = np.minimum(along.astype(int), PARTS - 1)
    table = layer_field(thickness * DEPTH, DEPTH, quantity == "strain")
    n, m, s, o, e = np.einsum("nfp,np->fn", table[part], (along - part)[:, None] ** np.arange(4))
    drag = q * x + r * y
    got = np.stack([q * e - x * (f * s + drag * o), r * e - y * (f * s + drag * o), f * n - drag * m], axis=-1)
    medium = Medium(MODULUS, quantity=quantity)
    wanted = layer_load(at * DEPTH, DEPTH, [[0.0, 0.0, q, r, f]], thickness * DEPTH, medium)
    wanted *= (4 * np.pi / 3 * MODULUS if quantity == "strain" else 2 * np.pi / 3) * DEPTH**2
    assert got == pytest.approx(wanted, abs=1.5e-7 * np.abs(wanted).max())


def test_no_thickness_and_a_very_large_one_are_the_half_space() -> None:
    for none in (None, np.inf, 2e3 * DEPTH):
        assert layer_field(none, DEPTH, True) is HALF_SPACE
    with pytest.raises(InputError, match=r"taxels 0.002 m deep under a cover of 0.001 m; a cover at least as thick"):
        layer_field(1e-3, 2e-3, True)
