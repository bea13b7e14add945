"""Sensitivity from a scan (eq. 18), and gains."""

import numpy as np
import pytest
from numpy.typing import NDArray

from cnnsim.support import InputError
from tactile.calibration.gains import Gains
from tactile.calibration.sensitivity import beta_from_scan
from tactile.elastic.halfspace import point_load_strain

DEPTH = 2e-4


def scan(places: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return strains (n, 3) of a taxel at the origin, under 20 mN at (x, 0) for every x [depths]."""
    loads = np.zeros((places.size, 1, 5))
    loads[:, 0, 0], loads[:, 0, 4] = places * DEPTH, 0.02
    return point_load_strain((0.0, 0.0), DEPTH, loads, 2.4e6)


@pytest.mark.parametrize("per_depth", [20, 40, 200])
@pytest.mark.parametrize("beta", [1.0, 1.46, 0.5])
def test_equation_18_with_samples_at_the_extrema(per_depth: int, beta: float) -> None:
    strain = scan(np.arange(-3 * per_depth, 3 * per_depth + 1) / per_depth)
    # the sensor's readings: T = u / alpha with alpha = (beta, beta, 1)
    got = beta_from_scan(strain[:, 0] / beta, strain[:, 2]).beta
    assert abs(got / beta - 1) < 1e-12


@pytest.mark.parametrize("level", [0.01, 0.03])
@pytest.mark.parametrize("count", [121, 1001])
@pytest.mark.parametrize("stress", [False, True])
def test_noise_does_not_bias_beta_and_sigma_is_right(count: int, level: float, stress: bool) -> None:
    random, found, wanted = np.random.default_rng(count), [], 1.5 if stress else 1.0  # the extrema of eq. (10)
    for _ in range(60):
        places = np.linspace(-4, 4, count) + random.uniform(-0.1, 0.1)
        strain = scan(places)
        if stress:
            strain = np.stack([places, 0 * places, -np.ones(count)], axis=-1) * (1 + places**2)[:, None] ** -2.5
        noisy = strain + random.normal(size=strain.shape) * level * np.abs(strain).max(axis=0)
        found.append(beta_from_scan(noisy[:, 0] / 1.46, noisy[:, 2]))
    error = np.array([one.beta for one in found]) / 1.46 / wanted - 1
    sigma = np.array([one.sigma for one in found]) / 1.46 / wanted
    assert abs(error.mean()) < 0.002 + 3 * error.std() / np.sqrt(error.size)
    assert 0.75 < error.std() / sigma.mean() < 1.3


def test_scans_without_extrema_are_refused() -> None:
    strain = scan(np.arange(0, 81) / 20)  # starts above the taxel
    with pytest.raises(InputError, match="beyond every extremum"):
        beta_from_scan(strain[:, 0], strain[:, 2])
    with pytest.raises(InputError, match="no signal"):
        beta_from_scan(np.zeros(9), np.zeros(9))
    with pytest.raises(InputError, match=r"\(3,\).*\(4,\)"):
        beta_from_scan(np.ones(3), np.ones(4))
    with pytest.raises(InputError, match="NaN"):
        beta_from_scan([1.0, np.nan, 0.0], np.ones(3))


def test_gains() -> None:
    gains = Gains(shear=3.0, normal=2.0)
    assert gains.beta_ns == 1.5
    assert gains(np.ones((2, 2, 3))).tolist() == [[[3.0, 3.0, 2.0]] * 2] * 2
    with pytest.raises(InputError, match="shear gain nan"):
        Gains(float("nan"), 1.0)
