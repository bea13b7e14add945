"""Cylinders lying on a layer: against a solver that knows the surface under each of many strips, and thin layers."""

import numpy as np
import pytest

from cnnsim.support import Floats, InputError
from tactile.elastic.lines import cylinder_half_width, line_indentation
from tactile.elastic.medium import Medium
from tactile.elastic.strip_contact import WIDEST, strip_contact


def compliance(k: Floats, nu: float) -> Floats:
    """T(k): the bonded layer's surface over the half-space's, as Johnson's eq. (5.65)."""
    kappa = 3 - 4 * nu
    return (2 * kappa * np.sinh(2 * k) - 4 * k) / (2 * kappa * np.cosh(2 * k) + 4 * k**2 + 1 + kappa**2)


def by_strips(b: float, nu: float, count: int = 300) -> tuple[float, Floats, Floats]:
    """Force, places over b and pressures under a cylinder of E* = R = h = 1 that touches from -b to b."""
    k = np.arange(0.5, 6000) * 5e-3
    edges = np.linspace(-b, b, count + 1)
    x, pitch = (edges[1:] + edges[:-1]) / 2, 2 * b / count
    apart = np.arange(count) * pitch
    ends = apart[:, None] + np.array([0.5, -0.5]) * pitch
    logarithm = np.diff(ends * np.log(np.abs(ends)) - ends, axis=1)[:, 0]  # the half-space's, to a constant
    taken = (np.cos(np.outer(apart, k)) - 1) @ ((1 - compliance(k, nu)) / k * 5e-3)
    sinks = (2 / np.pi) * (logarithm - taken * pitch)
    both = np.stack([np.ones(count), x**2 / 2], axis=-1)
    level, bent = np.linalg.solve(sinks[np.abs(np.subtract.outer(np.arange(count), np.arange(count)))], both).T
    rim = slice(count - 12, count - 3)  # no infinite pressure at the rim
    infinite = [
        np.polyval(np.polyfit(1 - x[rim] / b, (p * np.sqrt(1 - (x / b) ** 2))[rim], 2), 0) for p in (level, bent)
    ]
    pressure = infinite[1] / infinite[0] * level - bent
    return float(pressure.sum() * pitch), x / b, pressure


@pytest.mark.parametrize("nu", (0.5, 0.3))
@pytest.mark.parametrize("b", (0.1, 1.0, 3.0))
def test_the_contact_is_that_of_many_strips(b: float, nu: float) -> None:
    force, at, pressure = by_strips(b, nu)
    law = strip_contact(nu)
    assert float(law.force(np.array(b))) == pytest.approx(force, rel=1e-3)
    assert float(law.width(np.array(force))) == pytest.approx(b, rel=1e-3)
    found = law.shape(np.full(at.size, b), at) * 2 / (np.pi * b) * np.sqrt(1 - at**2) * force
    inner = np.abs(at) < 0.95
    assert np.abs(found - pressure)[inner].max() < 1e-3 * pressure.max()


@pytest.mark.parametrize("nu", (0.5, 0.0))
def test_a_width_is_where_its_force_is_from_the_narrowest_to_the_widest(nu: float) -> None:
    law = strip_contact(nu)
    b = np.concatenate([[0.0, 1e-150], np.geomspace(1e-12, WIDEST, 500), WIDEST * (1 - np.geomspace(1e-12, 0.1, 20))])
    force = law.force(b)
    assert (np.abs(law.width(force) - b) <= 1e-12 * b).all()
    low, high = b * 0.9, np.minimum(b * 1.1, WIDEST)  # the force grows with the width: halving cannot miss it
    for _ in range(60):
        middle = (low + high) / 2
        less = law.force(middle) < force
        low, high = np.where(less, middle, low), np.where(less, high, middle)
    assert law.width(force) == pytest.approx((low + high) / 2, rel=1e-12, abs=0)
    assert law.width(np.array(-1.0)) == 0
    with pytest.raises(InputError, match="over 40 thicknesses of the cover wide"):
        law.width(np.array([0.0, force.max() * 1.001]))


def test_layers_much_thinner_than_the_contact_is_wide() -> None:
    # incompressible: a film of rubber squeezed out, as wide as b and a constant at both rims; else a mattress
    b, stiff = np.array([10.0, 20.0]), 0.75
    rim = (strip_contact(0.5).force(b) * 45 / (2 * stiff)) ** 0.2 - b
    assert rim == pytest.approx(1.45, rel=0.01)
    modulus = (1 - 0.3**2) * 0.7 / (1.3 * 0.4)
    rim = np.cbrt(strip_contact(0.3).force(b) * 3 / (2 * modulus)) - b
    assert np.diff(rim) == pytest.approx(0, abs=2e-3)


@pytest.mark.parametrize(("nu", "b"), [(0.5, 0.3), (0.5, 3.0), (0.3, 6.0)])
def test_how_far_a_long_cylinder_sinks_in(nu: float, b: float) -> None:
    medium = Medium(1.0, nu, thickness=1.0)
    star, length = medium.contact_modulus, 4000.0
    force = float(strip_contact(nu).force(np.array(b))) * star * length  # of a radius of 1
    assert cylinder_half_width(force, length, 1.0, medium) == pytest.approx(b, rel=1e-9)
    t = np.cos((np.arange(400) + 0.5) * np.pi / 400)
    share = (1 - t**2) * strip_contact(nu).shape(np.full(400, b), t)
    k = np.arange(0.5, 20_000) * 2e-3
    waves = np.cos(np.outer(k, b * t)) @ (share / share.sum())
    deep = 2 / (np.pi * star) * force / length * (np.sum(compliance(k, nu) / k * waves) * 2e-3)
    found = float(line_indentation(np.array(force), length, np.array(b), medium))
    assert found == pytest.approx(deep, rel=2e-3)
