"""Torque of shear beyond that of the pressure: rigid turns, pulls, uneven unloading, noise; twist events."""

import numpy as np
import pytest

from tactile.events.signals.turn_numba import turn
from tests.kits.touch.made import events, force_stream

SHAPE = (4, 6)


def turned(press: np.ndarray, shear: np.ndarray, noise: tuple[float, float] = (0.0, 0.0)) -> float:
    fast = np.concatenate([shear, press[..., None]], axis=-1)
    slow = np.concatenate([np.zeros_like(shear), press[..., None]], axis=-1)
    return float(turn(fast, slow, np.ones(SHAPE, bool), *(np.full(SHAPE, one) for one in noise)))


@pytest.mark.parametrize("seed", range(4))
def test_a_rigid_turn_has_torque_and_a_pull_or_a_spread_has_none(seed: int) -> None:
    rng = np.random.default_rng(seed)
    press = rng.uniform(0.1, 1.0, SHAPE)
    y, x = np.mgrid[: SHAPE[0], : SHAPE[1]].astype(float)
    x, y = x - (press * x).sum() / press.sum(), y - (press * y).sum() / press.sum()
    around = 0.2 * press[..., None] * np.stack([-y, x], axis=-1)  # clockwise where y points down
    assert turned(press, around) > 0.25
    assert turned(press, -around) == -turned(press, around)
    assert abs(turned(press, 0.2 * press[..., None] * np.stack([x, y], axis=-1))) < 1 / 6
    assert (
        abs(turned(press, press[..., None] * rng.uniform(-0.5, 0.5, 2))) < 1 / 6
    )  # friction proportional to the pressure
    assert abs(turned(press, 0.02 * around)) < 1 / 6  # small for this load
    assert abs(turned(press, around, noise=(1.0, 0.0))) < 1 / 6
    aside = press[..., None] * [0.0, 0.5] + around
    assert turned(press, aside) > 0.25 > 1 / 6 > turned(press, aside, noise=(0.0, 1.0))  # the centre is uncertain
    assert turned(press, 0 * around) == turned(0 * press, around) == 0


@pytest.mark.parametrize("seed", range(4))
def test_a_shifted_and_unevenly_unloaded_contact_has_no_torque(seed: int) -> None:
    """Each taxel keeps its ratio of shear to pressure; taxels without pressure before have the mean ratio."""
    rng, use, quiet = np.random.default_rng(seed), np.ones(SHAPE, bool), np.zeros(SHAPE)
    friction = np.array([0.4, -0.2]) + 0.1 * rng.standard_normal((*SHAPE, 2))
    before, after = (np.where(rng.random(SHAPE) < 0.3, 0.0, rng.uniform(0.2, 1.0, SHAPE)) for _ in range(2))
    friction[before == 0] = (friction * before[..., None]).sum((0, 1)) / before.sum()
    slow, fast = (np.concatenate([friction * n[..., None], n[..., None]], axis=-1) for n in (before, after))
    assert abs(turn(fast, slow, use, quiet, quiet)) < 1 / 6
    y, x = np.mgrid[: SHAPE[0], : SHAPE[1]] - np.array(SHAPE)[:, None, None] / 2
    fast[..., :2] += 0.2 * after[..., None] * np.stack([-y, x], axis=-1)
    assert turn(fast, slow, use, quiet, quiet) > 0.25


@pytest.mark.parametrize(("way", "sense"), [(1, "clockwise"), (-1, "anticlockwise")])
def test_opposite_shear_on_two_edges_is_a_twist(way: int, sense: str) -> None:
    """No 3 x 3 neighbourhood contains both edges."""
    rng = np.random.default_rng(5)
    t = np.arange(0.0, 2.2, 0.005)
    values = 2e-3 * rng.standard_normal((len(t), 6, 6, 3))
    values[..., [0, 5], 2] += 0.5 * np.interp(t, [0.5, 0.6], [0, 1])[:, None, None]
    pull = 0.2 * way * np.interp(t, [1.5, 1.9], [0, 1])[:, None]
    values[..., 5, 1] += pull
    values[..., 0, 1] -= pull
    found = events(force_stream(t, values, 3e-3), tare="auto")
    assert [event.data["sense"] for event in found if event.kind == "twist"] == [sense]
    assert not [event for event in found if event.kind in ("pull", "spread", "pinch")]
