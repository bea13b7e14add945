"""Noise makes no events on arrays of any size, and a touch is still detected."""

from collections.abc import Iterator

import numpy as np
import pytest
from scipy.stats import norm

from cnnsim.support import Floats
from tactile.core.frame import NORMAL, Frame, Quantity, TaxelArray
from tactile.core.noise import Noise
from tactile.core.source import FrameStream
from tactile.thresholds.levels import FEW, SIGMAS, levels
from tests.kits.touch.made import events

ON: dict[Quantity, float] = {"force": 0.075, "strain": 1.5e-3, "stress": 3e3}
"""Default contact thresholds."""


def noise_of(side: int, quantity: Quantity, sigma: float, frames: int, touch: Floats, seed: int = 0) -> FrameStream:
    """Return frames of noise at 100 frames/s, with a ``touch`` (rows, cols) added in the second half."""
    array = TaxelArray("tip", side, side, 1.5e-3, 1.5e-3, quantity=quantity)
    random, valid = np.random.default_rng(seed), np.ones((side, side), bool)

    def each() -> Iterator[Frame]:
        for n in range(frames):
            values = sigma * random.normal(size=(side, side, 3))
            values[..., NORMAL] += touch * (n >= frames / 2) * (1 if quantity == "force" else -1)
            yield Frame(0, n / 100, n, values, valid)

    return FrameStream("noise", (array,), 2.4e6, frames, each())


@pytest.mark.parametrize("tare", ["off", "auto"])
@pytest.mark.parametrize("quantity", list(ON))
@pytest.mark.parametrize(("side", "frames"), [(2, 1000), (4, 1000), (8, 800), (32, 400), (128, 150)])
def test_noise_makes_no_event(side: int, frames: int, quantity: Quantity, tare: str) -> None:
    """Noise of a quarter of the contact threshold: of 16384 taxels, some exceed it in every frame."""
    for seed in range(2):
        source = noise_of(side, quantity, ON[quantity] / 4, frames, np.zeros((side, side)), seed)
        assert [(event.kind, event.t) for event in events(source, tare=tare)] == []


@pytest.mark.parametrize("side", [2, 16, 64])
def test_a_touch_on_a_few_taxels_is_detected(side: int) -> None:
    touch = np.zeros((side, side))
    touch[:2, :2] = 1.0
    found = events(noise_of(side, "force", ON["force"] / 4, 200, touch), tare="off")
    assert found[0].kind == "contact"
    assert found[0].t == pytest.approx(1.0, abs=0.02)
    assert sum(event.kind == "contact" for event in found) == 1


@pytest.mark.parametrize("taxels", [1, 4, 16, 64, 256, 1024, 16384])
def test_the_false_alarm_rate_does_not_grow_with_the_array(taxels: int) -> None:
    noise = Noise(np.ones((1, taxels, 3)), np.ones((1, taxels, 3)), np.zeros((1, taxels), bool), np.ones(3))
    found = levels((1, taxels), "force", SIGMAS, None, None, noise)
    on = float(found.on[0, 0, NORMAL])
    assert taxels * norm.sf(on) <= FEW * norm.sf(2 * SIGMAS.contact) * 1.0001
    assert on == 2 * SIGMAS.contact if taxels <= FEW else 2 * SIGMAS.contact < on < 7
    assert (found.off[..., NORMAL] == SIGMAS.contact).all()
