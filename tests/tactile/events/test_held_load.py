"""Held load: settled and loosened at any tempo; frozen taxels are left out."""

import numpy as np
import pytest

from tactile.core.frozen import LEAST, Frozen
from tactile.events.signals.held_load import HeldLoad

TIMES, FORCES = [0.0, 0.2, 0.3, 4.0, 4.12, 4.5], [0.0, 20.0, 6.0, 6.0, 0.2, 0.15]
"""Times [s] and forces [N] of a grip that overshoots, holds, opens and leaves a creeping rest."""


@pytest.mark.parametrize("tempo", [1 / 16, 1.0, 4.0])
@pytest.mark.parametrize("gain", [0.01, 100.0])
def test_a_grip_is_loosened_at_the_knee_of_its_fall_at_any_tempo_and_gain(tempo: float, gain: float) -> None:
    """The held load does not settle while the grip closes, and it is loosened once, near the end of the fall."""
    one, held, before = HeldLoad(), 0.0, 0.0
    settled, loosened = [], []
    for t in np.arange(0.0, 4.5, 0.002 * max(tempo, 1)):
        load = gain * float(np.interp(t, TIMES, FORCES))
        dt = (t - before) / tempo
        held += one.follows(dt, True) * (load - held)
        one.update(t / tempo, load, held, 0.002 * max(tempo, 1) / tempo, True, True)
        settled += [t] if one.settled else []
        loosened += [t] if one.loosened else []
        before = t
    assert 0.3 < min(settled) < 1.0
    assert max(settled) < 4.1
    assert 4.05 < min(loosened) < 4.2


def test_a_taxel_that_repeats_its_reading_is_left_out_until_it_changes() -> None:
    rng, frozen, none = np.random.default_rng(1), Frozen((2, 2)), np.zeros((2, 2), bool)
    values, pressed = rng.standard_normal((200, 2, 2, 3)), np.array([[True, True], [False, False]])
    values[50:150, 0, 1] = values[50, 0, 1]
    values[60:, 1, 1] = 0.0  # unpressed
    values[170:180] = values[170]  # repeated frames
    found = [frozen(one, pressed, none)[0, 1] for one in values]
    assert not any(found[: 50 + LEAST])
    assert all(found[52 + LEAST : 150])
    assert not any(found[150:])
    assert frozen.words() == ""
    steps = np.repeat(np.round(values[:40]), 5, axis=0)  # a coarse converter repeats
    coarse = Frozen((2, 2))
    assert not any(coarse(one, pressed, none).any() for one in steps)
