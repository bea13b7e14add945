"""Friction with its memory: Cattaneo, Mindlin, Deresiewicz."""

import numpy as np
import pytest

from cnnsim.support import InputError
from tactile.elastic.medium import Medium
from tactile.elastic.profiles import hertz_radius
from tactile.simulator.contacts.friction import FrictionState, load_to, untouched

MU = 0.6

RUBBER = Medium(2.4e6)

random = np.random.default_rng(2)


def loaded(*steps: tuple[float, float, float]) -> FrictionState:
    """A contact that went through (normal, Q, R) one after the other."""
    state = untouched(MU)
    for normal, q, r in steps:
        state = load_to(state, normal, np.array([q, r]))
    return state


@pytest.mark.parametrize("share", (0.0, 0.1, 0.5, 0.9, 0.999))
def test_cattaneo_mindlin_stick_radius(share: float) -> None:
    # c / a = (1 - Q / mu P)^(1/3); forces go with the cube of radii
    for turn in (0.0, 2.0):
        pull = share * MU * 2.0
        state = loaded((2.0, 0, 0), (2.0, pull * np.cos(turn), pull * np.sin(turn)))
        assert np.cbrt(state.sticks / 2.0) == pytest.approx((1 - share) ** (1 / 3), rel=1e-12)
        assert state.force == pytest.approx((pull * np.cos(turn), pull * np.sin(turn)), abs=1e-14)
        assert not state.slipping


def test_traction_of_cattaneo_mindlin() -> None:
    state = loaded((2.0, 0, 0), (2.0, 0.7, 0))
    at, force = state.terms()
    radius = hertz_radius(at, 1e-3, RUBBER.contact_modulus)
    r = np.linspace(0, 0.999 * radius[-1], 50)
    traction = sum(
        1.5 * f[0] / (np.pi * a * a) * np.sqrt(np.maximum(1 - (r / a) ** 2, 0))
        for a, f in zip(radius, force, strict=True)
    )
    a, c = radius[-1], radius[-1] * (1 - 0.7 / (MU * 2)) ** (1 / 3)
    p0 = 1.5 * 2.0 / (np.pi * a * a)
    wanted = MU * p0 * (np.sqrt(1 - (r / a) ** 2) - c / a * np.sqrt(np.maximum(1 - (r / c) ** 2, 0)))
    assert traction == pytest.approx(wanted, rel=1e-9, abs=1e-9 * p0)
    limit = MU * p0 * np.sqrt(1 - (r / a) ** 2)
    assert (traction <= limit * (1 + 1e-12)).all()  # slips in the ring, sticks inside


def test_unloading_follows_mindlin_and_deresiewicz() -> None:
    # after Q1 the shear falls to Q: a ring slips back to c with (c / a)^3 = 1 - (Q1 - Q) / (2 mu P)
    limit = MU * 2.0
    for back in (0.5, 0.0, -0.3):
        state = loaded((2.0, 0, 0), (2.0, 0.8 * limit, 0), (2.0, back * limit, 0))
        assert state.sticks / 2.0 == pytest.approx(1 - (0.8 - back) / 2, rel=1e-12)
    # a full cycle closes, and what happened inside it is forgotten
    once = loaded((2.0, 0, 0), (2.0, 0.8 * limit, 0))
    cycle = loaded((2.0, 0, 0), (2.0, 0.8 * limit, 0), (2.0, 0.1, 0), (2.0, 0.5, 0), (2.0, 0.8 * limit, 0))
    for one, other in zip(once.terms(), cycle.terms(), strict=True):
        assert one == pytest.approx(other, rel=1e-9, abs=1e-12)


def test_pressing_harder_while_shear_grows_sticks_everywhere() -> None:
    # Mindlin and Deresiewicz: no slip while dQ < mu dP, whatever the steps
    state = untouched(MU)
    for k in range(1, 11):
        state = load_to(state, k * 0.1, np.array([k * 0.1 * MU * 0.9, 0.0]))
        assert state.sticks == pytest.approx(k * 0.1)
    assert np.hypot(*state.shares.T) == pytest.approx(np.full(len(state.shares), 0.9))
    one = loaded((1.0, MU * 0.9, 0))
    assert one.force == pytest.approx(state.force)


def test_full_slip_and_forgetting() -> None:
    assert loaded((2.0, 5.0, 0)).slipping
    assert loaded((2.0, 5.0, 0)).force == pytest.approx((MU * 2.0, 0))
    assert loaded((2.0, 0.5, 0), (0.0, 0.0, 0)).ends.size == 0
    assert loaded((2.0, 0.5, 0), (0.0, 0.1, 0)).slipping
    frictionless = load_to(untouched(0.0), 1.0, np.array([0.1, 0.0]))
    assert not frictionless.force.any()
    with pytest.raises(InputError, match="friction coefficient -1"):
        untouched(-1.0)


def test_any_history_carries_what_is_asked_within_coulombs_limit() -> None:
    for _ in range(30):
        state = untouched(MU)
        for _ in range(60):
            normal = random.uniform(0, 3)
            size, turn = random.uniform(0, 1.2) * MU * normal, random.uniform(0, 2 * np.pi)
            asked = size * np.array([np.cos(turn), np.sin(turn)])
            state = load_to(state, normal, asked)
            if size < MU * normal:
                assert state.force == pytest.approx(asked, abs=1e-12)
            else:
                assert np.hypot(*state.force) == pytest.approx(MU * normal)
            assert (np.hypot(*state.shares.T) <= 1 + 1e-9).all()
            assert (np.diff(state.ends, prepend=0.0) > 0).all()
            assert 0 <= state.sticks <= normal + 1e-12
            assert state.terms()[1].sum(axis=0) == pytest.approx(state.force, abs=1e-12)
