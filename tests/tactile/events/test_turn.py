"""Torque of shear that the pressing does not explain: rigid turns, pulls, uneven unloading, noise; twists."""

import numpy as np
import pytest

from tactile.core.frame import Frame, TaxelArray
from tactile.core.source import FrameStream, Provenance
from tactile.events.signals.turn_numba import turn
from tests.kits.touch.made import events

SHAPE = (4, 6)


def turned(press: np.ndarray, shear: np.ndarray, noise: tuple[float, float] = (0.0, 0.0)) -> float:
    fast = np.concatenate([shear, press[..., None]], axis=-1)
    slow = np.concatenate([np.zeros_like(shear), press[..., None]], axis=-1)
    return float(turn(fast, slow, np.ones(SHAPE, bool), *(np.full(SHAPE, one) for one in noise)))


@pytest.mark.parametrize("seed", range(4))
def test_a_rigid_turn_about_the_middle_of_the_pressing_turns_and_a_pull_or_a_spread_does_not(seed: int) -> None:
    rng = np.random.default_rng(seed)
    press = rng.uniform(0.1, 1.0, SHAPE)
    y, x = np.mgrid[: SHAPE[0], : SHAPE[1]].astype(float)
    x, y = x - (press * x).sum() / press.sum(), y - (press * y).sum() / press.sum()
    around = 0.2 * press[..., None] * np.stack([-y, x], axis=-1)  # clockwise where y points down
    assert turned(press, around) > 0.25
    assert turned(press, -around) == -turned(press, around)
    assert abs(turned(press, 0.2 * press[..., None] * np.stack([x, y], axis=-1))) < 1 / 6
    assert abs(turned(press, press[..., None] * rng.uniform(-0.5, 0.5, 2))) < 1 / 6  # friction is as the pressing
    assert abs(turned(press, 0.02 * around)) < 1 / 6  # little for such a load
    assert abs(turned(press, around, noise=(1.0, 0.0))) < 1 / 6
    aside = press[..., None] * [0.0, 0.5] + around
    assert turned(press, aside) > 0.25 > 1 / 6 > turned(press, aside, noise=(0.0, 1.0))  # the middle is not known
    assert turned(press, 0 * around) == turned(0 * press, around) == 0


@pytest.mark.parametrize("seed", range(4))
def test_a_contact_that_is_shifted_and_unloaded_unevenly_does_not_turn(seed: int) -> None:
    """Each taxel keeps its shear for a pressing; where nothing pressed before it is that of all of them."""
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
def test_an_object_that_bears_on_two_edges_is_turned(way: int, sense: str) -> None:
    """No taxel sees both edges in its neighbourhood: opposing signs alone would call that a pull."""
    rng, array = np.random.default_rng(5), TaxelArray("pad", 6, 6, 3e-3, 0.0, quantity="force")
    t = np.arange(0.0, 2.2, 0.005)
    values = 2e-3 * rng.standard_normal((len(t), 6, 6, 3))
    values[..., [0, 5], 2] += 0.5 * np.interp(t, [0.5, 0.6], [0, 1])[:, None, None]
    pull = 0.2 * way * np.interp(t, [1.5, 1.9], [0, 1])[:, None]
    values[..., 5, 1] += pull
    values[..., 0, 1] -= pull
    frames = [
        Frame(0, time, n, one, np.ones((6, 6), bool))
        for n, (time, one) in enumerate(zip(t.tolist(), values, strict=True))
    ]
    found = events(FrameStream("edges", (array,), None, len(frames), frames, Provenance(untared=True)), tare="auto")
    assert [event.data["sense"] for event in found if event.kind == "twist"] == [sense]
    assert not [event for event in found if event.kind in ("pull", "spread", "pinch")]
