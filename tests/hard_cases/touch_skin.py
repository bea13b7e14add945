"""Hard cases of the skin: thick and thin layers, nu -> 1/2, Prony terms, stick-slip without force, locking elements."""

from collections.abc import Callable
from functools import partial
from typing import Any

import numpy as np

from cnnsim.backends.base import Backend
from cnnsim.support import Array, Floats
from tactile.bump.body import Body
from tactile.bump.kinematics import PRESSED
from tactile.bump.law import Displacement, Mixed
from tactile.elastic.layer import transfer
from tactile.elastic.medium import Medium
from tactile.simulator.contacts.friction import load_to, untouched
from tactile.simulator.effects.viscoelastic import Viscoelastic
from tests.hard_cases.case import HardCase
from tests.kits.touch.effects import through
from tests.oracles.elastic.layer_waves import float_transfer, mp_transfer
from tests.oracles.elastic.point_loads import boussinesq
from tests.tactile.bump.test_elements import on_boundary, shaken, with_boundary


def _layer(given: tuple[float, float, float, float], _: Backend) -> Array:
    k, depth, thickness, nu = given
    found = transfer(k, depth, thickness, Medium(2 * (1 + nu), nu))  # G = 1
    exact = mp_transfer(k, depth, thickness, nu)
    parts = np.array([float(part) for part in (found.normal, found.shear_normal, found.normal_shear, found.shear)])
    return (parts - exact) / np.abs(exact).max()


def _layer_naive(given: tuple[float, float, float, float]) -> Array:
    exact = mp_transfer(*given)
    return (float_transfer(*given) - exact) / np.abs(exact).max()


def _layers(name: str, why: str, given: tuple[float, float, float, float], **more: Any) -> HardCase:
    ours, naive = partial(_layer, given), partial(_layer_naive, given)
    return HardCase(name, why, ours, lambda: np.zeros(4), 1e-12, 1e-12, naive, **more)


DT = 0.01


def _ramp(tau: float, _: Backend) -> Array:
    values = np.linspace(0, 1, 50)[:, None, None, None] * np.ones((1, 1, 1, 3))
    return np.asarray(through(Viscoelastic(((0.5, tau),)), values, np.arange(50) * DT)[-1, 0, 0, :1])


def _ramp_exact(tau: float) -> Array:
    """y = x - g (x - h), h = slope tau (1 - exp(-t / tau)) from the frame before the ramp."""
    import mpmath

    with mpmath.workdps(60):
        t, slope, tau_ = 49 * mpmath.mpf(DT), 1 / (49 * mpmath.mpf(DT)), mpmath.mpf(tau)
        h = slope * tau_ * -mpmath.expm1(-t / tau_)
        return np.array([float(1 - mpmath.mpf("0.5") * (1 - h))])


def _euler(tau: float) -> Array:
    """dh/dt = dx/dt - h / tau by explicit Euler."""
    h, slope = 0.0, 1 / 49
    for _ in range(49):
        h = h + slope - DT / tau * h
    return np.array([1 - 0.5 * (1 - h)])


def _cancelled(tau: float) -> Array:
    """The recursion with 1 - exp instead of expm1."""
    h, keep = 0.0, np.exp(-DT / tau)
    for _ in range(49):
        h = keep * h + (1 - keep) * tau / DT / 49
    return np.array([1 - 0.5 * (1 - h)])


def _slipped(_: Backend) -> Array:
    """Grip, shear, lift off to exactly no force, shear without force, grip again: nothing of the first may remain."""
    state = untouched(0.5)
    for normal, q in ((1.0, 0.2), (0.5, 0.1), (0.0, 0.0), (0.0, 0.3)):
        state = load_to(state, normal, np.array([q, 0.0]))
    nothing = state.force if state.ends.size else np.zeros(2)
    again, fresh = (
        load_to(load_to(one, 1.0, np.zeros(2)), 1.0, np.array([0.3, 0.0])) for one in (state, untouched(0.5))
    )
    return np.concatenate([nothing, again.force, [again.sticks - fresh.sticks]])


def _mindlin() -> Array:
    """The sticking share 1 - Q / (mu N) of a contact without force."""
    normal, q = np.float64(0.0), np.float64(0.0)
    share = 1 - q / (0.5 * normal)
    return np.array([share * normal, 0.0, 0.3, 0.0, 0.0])


def _elements(law: Callable[[Medium], Any], _: Any = None) -> Array:
    """The largest error of a displacement under Boussinesq's load in a block of few elements, nu = 1/2 - 1e-9."""
    nu = 0.5 - 1e-9
    body = Body(shaken(6), PRESSED, law(Medium(2 * (1 + nu), nu)))

    def exact(r: Floats, z: Floats) -> Floats:
        return boussinesq(r, z, nu)

    state = with_boundary(body, exact, on_boundary(body))
    moves = body.component >= 0
    wanted = exact(*body.place)[np.maximum(body.component, 0), np.arange(body.size)]
    return np.array([np.abs(state - wanted)[moves].max()])


WAVE = "exp(k z) and exp(-k z) in one equation: one overflows"
PIVOTS = "pivoting is enough"


def _prony(name: str, why: str, tau: float, bound: float, naive: Callable[[float], Array]) -> HardCase:
    return HardCase(name, why, partial(_ramp, tau), partial(_ramp_exact, tau), bound, bound, partial(naive, tau))


CASES = [
    _layers("a wave in a layer, k h = 1", "nothing: the naive form is right", (1.0, 0.5, 1.0, 0.3), naive_fails=False),
    _layers("thick, k h = 1000", WAVE, (1.0, 0.5, 1e3, 0.3)),
    _layers("thin, k h = 1e-6", f"four nearly equal waves; {PIVOTS}", (1e-6, 0.5, 1.0, 0.3), naive_fails=False),
    _layers("taxels on the bottom", "depth = thickness", (2.0, 1.0, 1.0, 0.4), naive_fails=False),
    _layers("nu = 1/2", "1 / (1 - 2 nu) is infinite", (1.0, 0.5, 1.0, 0.5)),
    _layers(
        "nu = 1/2 - 1 ulp", f"1 / (1 - 2 nu) = 9e15; {PIVOTS}", (1.0, 0.5, 1.0, float(np.nextafter(0.5, 0))),
        naive_fails=False,
    ),
    _prony("Prony time 1e-12 of the frames'", "explicit steps are unstable", 1e-12 * DT, 1e-14, _euler),
    _prony("Prony time 1e12 of the frames'", "1 - exp(-dt / tau) cancels", 1e12 * DT, 1e-13, _cancelled),
    HardCase(
        "stick-slip at zero normal force", "the sticking share is 0/0, and no earlier state may remain", _slipped,
        lambda: np.array([0, 0, 0.3, 0, 0.0]), 1e-15, 1e-15, _mindlin,
    ),
    HardCase(
        "elements at nu = 1/2 - 1e-9", "displacements alone lock", partial(_elements, Mixed), lambda: np.zeros(1), 2e-3,
        2e-3, partial(_elements, Displacement),
    ),
]  # fmt: skip
