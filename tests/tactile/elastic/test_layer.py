"""The bonded layer: against the differential equations, the half-space, the other Poisson's ratios and itself."""

import itertools

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.linalg import expm

from cnnsim.support import InputError
from tactile.elastic.halfspace import point_load
from tactile.elastic.layer import transfer
from tactile.elastic.medium import FieldQuantity, Medium
from tests.oracles.elastic.layer import layer_load, layer_term, periodic_field

random = np.random.default_rng(11)


def oracle(k: float, depth: float, thickness: float, nu: float) -> NDArray[np.float64]:
    """[[zz from p, zz / i from q_s], [sz / i from p, sz from q_s]] stress, from the equations as a system in z.

    u_x = i U, u_z = W, sigma_xz = i T, sigma_zz = S; lambda and G from E = 1; nothing of the product's solution.
    """
    lam, g = nu / ((1 + nu) * (1 - 2 * nu)), 1 / (2 * (1 + nu))
    m = lam + 2 * g
    # U' = T/G - k W, W' = (S + lam k U)/m, T' = -k sigma_xx with sigma_xx = -m k U + lam W', S' = k T
    system = np.array(
        [
            [0, -k, 1 / g, 0],
            [lam * k / m, 0, 0, 1 / m],
            [k * k * (m - lam**2 / m), 0, 0, -k * lam / m],
            [0, 0, k, 0],
        ]
    )
    to_base, to_depth = expm(system * thickness), expm(system * depth)
    answers = []
    for t, s in ((0.0, -1.0), (1.0, 0.0)):  # p = 1 presses; q_s = 1: i T = -1, T = i: T counted in units of i
        displacement = np.linalg.solve(to_base[:2, :2], -to_base[:2, 2:] @ (t, s))
        state = to_depth @ np.array([*displacement, t, s])
        answers.append((state[3], state[2]))
    (zz_p, sz_p), (zz_q, sz_q) = answers
    # with T = i every amplitude is i times the real one: zz = i zz_q, sigma_sz = i (i sz_q) = -sz_q
    return np.array([[zz_p, zz_q], [sz_p, -sz_q]])


@pytest.mark.parametrize("nu", (0.0, 0.3, 0.49))
@pytest.mark.parametrize("depth", (0.0, 0.4, 1.0))
def test_transfer_functions_solve_the_equations(depth: float, nu: float) -> None:
    for k in (0.01, 0.3, 1.0, 4.0):
        by = transfer(k, depth, 1.0, Medium(1.0, nu, "stress"))
        got = np.array([[by.normal, by.normal_shear], [by.shear_normal, by.shear]])
        assert got == pytest.approx(oracle(k, depth, 1.0, nu), rel=1e-9, abs=1e-10)
        strain = transfer(k, depth, 1.0, Medium(1.0, nu))
        # normal strain needs the sideways strain too: at the base that is 0; shear serves everywhere
        assert strain.shear == pytest.approx(by.shear * (1 + nu), rel=1e-12)
        if depth == 1.0:
            assert strain.normal == pytest.approx(by.normal * (1 + nu) * (1 - 2 * nu) / (1 - nu), rel=1e-8, abs=1e-12)


def test_at_one_half_it_is_the_limit_and_nothing_breaks() -> None:
    k = np.concatenate([[0.0], 10.0 ** np.linspace(-8, 8, 60)])
    for quantity in ("strain", "stress"):
        for depth in (0.0, 0.3, 1.0):
            exact = transfer(k, depth, 1.0, Medium(1.0, 0.5, quantity))
            near = transfer(k, depth, 1.0, Medium(1.0, 0.5 - 1e-9, quantity))
            for name in ("normal", "normal_shear", "shear_normal", "shear", "across"):
                a, b = getattr(exact, name), getattr(near, name)
                assert np.isfinite(a).all()
                assert np.abs(a - b).max() < 1e-8
    base = transfer(k, 1.0, 1.0, Medium(1.0, 0.5))
    assert np.abs(base.normal).max() < 1e-14  # nothing stretches on the base, and the volume stays


def test_surface_and_uniform_pressure() -> None:
    k = np.array([0.0, 0.1, 1.0, 50.0])
    top = transfer(k, 0.0, 1.0, Medium(1.0, 0.4, "stress"))
    for name, value in (("normal", -1), ("shear", -1), ("across", -1), ("normal_shear", 0), ("shear_normal", 0)):
        assert getattr(top, name) == pytest.approx(np.full(4, value), abs=1e-14)
    uniaxial = transfer(0.0, 0.5, 1.0, Medium(1.0, 0.4))
    assert uniaxial.normal == pytest.approx(-(1.4 * 0.2) / 0.6)  # 1 / (lambda + 2 G)


@pytest.mark.parametrize(("nu", "quantity"), [(0.0, "strain"), (0.3, "stress"), (0.5, "strain")])
@pytest.mark.parametrize("depth", (0.5, 1.0))
def test_point_loads_are_the_sum_of_waves(depth: float, nu: float, quantity: FieldQuantity) -> None:
    count, pitch, medium = 384, 0.125, Medium(2.0, nu, quantity)
    x, y = np.meshgrid(*2 * ((np.arange(count) - count // 2) * pitch,))
    bump = np.exp(-(x**2 + y**2) / 2 / 0.3**2)
    force = np.array((0.3, -0.2, 0.5))
    waves = periodic_field(bump[..., None] * force, pitch, depth, 1.0, medium)
    near = slice(count // 2 - 20, count // 2 + 21)
    loads = np.concatenate(
        [np.stack([x, y], -1)[near, near], (bump * pitch**2)[near, near, None] * force], axis=-1
    ).reshape(-1, 5)
    for row, col in ((0, 0), (3, -5), (10, 7), (24, 0)):
        at = np.array([col * pitch, row * pitch])
        got, wanted = layer_load(at, depth, loads, 1.0, medium), waves[count // 2 + row, count // 2 + col]
        # points four to a depth stand for the smooth bump to exp(-2 pi 4)
        assert np.abs(got - wanted).max() < 1e-7 * np.abs(waves).max()


def test_a_thick_layer_is_the_half_space() -> None:
    at, loads = random.uniform(-2, 2, (50, 2)), np.array([[0.1, 0.2, 0.3, -0.4, 0.5]])
    for nu in (0.0, 0.5):
        for quantity in ("strain", "stress"):
            medium = Medium(1.0, nu, quantity)
            half = point_load(at, 0.5, loads, medium)
            gaps = [np.abs(layer_term(at, 0.5, loads, h, medium)).max() / np.abs(half).max() for h in (2, 8, 32, 1e4)]
            assert all(a > 3 * b for a, b in itertools.pairwise(gaps))
            assert gaps[-1] < 1e-7
            assert not layer_term(at, 0.5, loads, np.inf, medium).any()


def test_a_layer_carries_its_load() -> None:
    # the base under a point load: normal stress sums to the force, and shear to the shear
    nodes, weights = np.polynomial.legendre.leggauss(200)
    rho, step = (nodes + 1) * 15, weights * 15
    azimuth = (np.arange(16) + 0.5) * 2 * np.pi / 16
    at = rho[:, None, None] * np.stack([np.cos(azimuth), np.sin(azimuth)], axis=-1)
    felt = layer_load(at, 1.0, [[0, 0, 0.3, -0.2, 0.5]], 1.0, Medium(1.0, 0.4, "stress"))
    total = (felt * (rho * step)[:, None, None]).sum((0, 1)) * 2 * np.pi / 16
    assert total == pytest.approx((-0.3, 0.2, -0.5), rel=1e-6)


def test_wrong_layers_are_refused() -> None:
    with pytest.raises(InputError, match="thickness of at least the depth"):
        layer_term((0, 0), 2e-3, [[0, 0, 0, 0, 1]], 1e-3, Medium(1.0))
    with pytest.raises(InputError, match="depth from 0 to the thickness"):
        transfer(1.0, 2.0, 1.0, Medium(1.0))
    with pytest.raises(InputError, match="wavenumbers"):
        transfer(-1.0, 0.5, 1.0, Medium(1.0))
    with pytest.raises(InputError, match="map of shape"):
        periodic_field(np.zeros((4, 4)), 1.0, 0.5, 1.0, Medium(1.0))
