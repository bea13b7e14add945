"""Loads along lines: against many point loads along them, and the closed form of a long cylinder."""

import numpy as np
import pytest

from cnnsim.support import InputError
from tactile.elastic.halfspace import point_load
from tactile.elastic.lines import cylinder_half_width, cylinder_loads, edge_loads
from tactile.elastic.medium import Medium

random = np.random.default_rng(3)


def test_an_edge_and_a_cylinder_are_as_they_should() -> None:
    load, medium, at = (1e-4, 2e-4, 0.01, -0.02, 0.05), Medium(2.4e6, 0.4), random.uniform(-2e-3, 2e-3, (20, 2))
    for depth in (1e-4, 1e-3):
        loads = edge_loads(load, 2e-3, 0.4, depth)
        assert loads.sum(axis=0)[2:] == pytest.approx(load[2:], rel=1e-12)
        s = np.linspace(-1e-3, 1e-3, 200_001)
        share = np.full(s.size, 1 / (s.size - 1))
        share[[0, -1]] /= 2  # the trapezoidal rule
        fine = np.stack([load[0] + s * np.cos(0.4), load[1] + s * np.sin(0.4), *(f * share for f in load[2:])], axis=-1)
        wanted = point_load(at, depth, fine, medium)
        assert np.abs(point_load(at, depth, loads, medium) - wanted).max() < 1e-8 * np.abs(wanted).max()
    width = cylinder_half_width(0.05, 2e-3, 1e-3, medium)
    assert width == pytest.approx(np.sqrt(4 * 0.05 * 1e-3 / (np.pi * medium.contact_modulus * 2e-3)))
    # Johnson's eq. (4.45): on the axis of a long cylinder sigma_zz = -p0 / sqrt(1 + (z / b)^2)
    loads = cylinder_loads((0, 0, 0, 0, 0.4), 0.4, np.array(1e-3), 0.3, 2e-3)
    peak = 2 * 1.0 / (np.pi * 1e-3)
    middle = point_load((0, 0), 2e-3, loads, Medium(1.0, quantity="stress"))[2]
    assert middle == pytest.approx(-peak / np.sqrt(5), rel=1e-5)
    with pytest.raises(InputError, match="depths long"):
        edge_loads(load, 1.0, 0.0, 1e-5)
    with pytest.raises(InputError, match="positive"):
        edge_loads(load, 0.0, 0.0, 1e-5)
