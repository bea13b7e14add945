"""The half-space under point loads: Hooke's law, equilibrium, superposition."""

import numpy as np
import pytest

from cnnsim.support import InputError
from tactile.elastic.halfspace import point_load_strain, point_load_stress
from tests.oracles.elastic.boussinesq import stress_tensor

DEPTH = 2e-4
MODULUS = 2.4e6


def random_cases(count: int) -> list[tuple[tuple[float, float], tuple[float, float, float, float, float]]]:
    random = np.random.default_rng(3)
    at = random.uniform(-8e-4, 8e-4, (count, 2))
    loads = np.hstack([random.uniform(-8e-4, 8e-4, (count, 2)), random.uniform(-0.05, 0.05, (count, 3))])
    return [(tuple(a), tuple(load)) for a, load in zip(at.tolist(), loads.tolist(), strict=True)]


@pytest.mark.parametrize("nu", [0.0, 0.3, 0.45])
@pytest.mark.parametrize(("at", "load"), random_cases(8))
def test_stress_follows_from_hookes_law_at_any_poisson_ratio(
    at: tuple[float, float], load: tuple[float, float, float, float, float], nu: float
) -> None:
    seen = (at[0] - load[0], at[1] - load[1], DEPTH)
    tensor = stress_tensor(seen, load[2:], nu)
    got = point_load_stress(at, DEPTH, [load])
    assert np.abs(got - tensor[2]).max() < 1e-11 * np.abs(tensor).max()


def test_a_plane_carries_the_load() -> None:
    # polar grid: the midpoint rule in the angle is exact, Gauss-Legendre in rho = z tan(angle) nearly so
    load = (1e-5, -2e-5, 0.013, -0.021, 0.034)
    nodes, weights = np.polynomial.legendre.leggauss(60)
    slant = (nodes + 1) * np.pi / 4
    rho = DEPTH * np.tan(slant)
    jacobian = rho * DEPTH / np.cos(slant) ** 2 * weights * np.pi / 4
    azimuth = (np.arange(16) + 0.5) * 2 * np.pi / 16
    at = np.stack([load[0] + rho[:, None] * np.cos(azimuth), load[1] + rho[:, None] * np.sin(azimuth)], axis=-1)
    traction = point_load_stress(at, DEPTH, [load])
    total = (traction * jacobian[:, None, None]).sum((0, 1)) * 2 * np.pi / 16
    assert total == pytest.approx((-load[2], -load[3], -load[4]), rel=1e-10)


def test_loads_add_and_broadcast() -> None:
    at = np.random.default_rng(1).uniform(-1e-3, 1e-3, (4, 3, 2))
    loads = np.array([(1e-4, 0, 0.01, 0, 0.02), (-2e-4, 1e-4, 0, 0.03, -0.01)])
    apart = [point_load_strain(at, DEPTH, load[None], MODULUS) for load in loads]
    assert np.allclose(point_load_strain(at, DEPTH, loads, MODULUS), sum(apart), rtol=1e-13)
    in_time = point_load_stress(at, DEPTH, loads[:, None, None, None, :])
    for frame, load in zip(in_time, loads, strict=True):
        assert np.array_equal(frame, point_load_stress(at, DEPTH, load[None]))
    assert np.array_equal(point_load_strain(at, DEPTH, np.empty((0, 5)), MODULUS), np.zeros((4, 3, 3)))


def test_wrong_input_is_refused() -> None:
    with pytest.raises(InputError, match=r"depth -1"):
        point_load_stress((0, 0), -1, [(0, 0, 0, 0, 1)])
    with pytest.raises(InputError, match=r"\(1, 4\)"):
        point_load_stress((0, 0), 1, [(0, 0, 0, 1)])
    with pytest.raises(InputError, match=r"shape \(3,\)"):
        point_load_stress((0, 0, 0), 1, [(0, 0, 0, 0, 1)])
    with pytest.raises(InputError, match="modulus 0"):
        point_load_strain((0, 0), 1, [(0, 0, 0, 0, 1)], 0)


def test_shear_points_to_what_presses_and_against_a_pull() -> None:
    """As CONNECT.md tells how to try the signs of a board: a tip to the right, then a push to the right."""
    here, tip = (0.0, 0.0), [(1e-4, 0.0, 0.0, 0.0, 0.02)]
    for pressed in (point_load_strain(here, DEPTH, tip, MODULUS), point_load_stress(here, DEPTH, tip)):
        assert pressed[0] > 0 > pressed[2]
    for x in (-1e-4, 1e-4):
        push = [(x, 0.0, 0.01, 0.0, 0.0)]
        assert point_load_strain(here, DEPTH, push, MODULUS)[0] < 0
        assert point_load_stress(here, DEPTH, push)[0] < 0
