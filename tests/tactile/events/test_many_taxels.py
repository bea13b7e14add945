"""Pure noise makes no events however many taxels there are, and a touch is still felt by all of them."""

from collections.abc import Iterator

import numpy as np
import pytest
from scipy.stats import norm

from cnnsim.support import Floats
from tactile import Settings, run
from tactile.core.frame import NORMAL, Frame, Quantity, TaxelArray
from tactile.core.noise import Noise, early_noise
from tactile.core.source import FrameStream
from tactile.events.event import Event
from tactile.thresholds.levels import FEW, SIGMAS, levels

ON: dict[Quantity, float] = {"force": 0.075, "strain": 1.5e-3, "stress": 3e3}
"""Where contact begins while no noise is known."""


def noise_of(side: int, quantity: Quantity, sigma: float, frames: int, touch: Floats, seed: int = 0) -> FrameStream:
    """Frames of noise alone, and in their last half of a ``touch`` (rows, cols) on top, a hundred a second."""
    array = TaxelArray("tip", side, side, 1.5e-3, 1.5e-3, quantity=quantity)
    random, valid = np.random.default_rng(seed), np.ones((side, side), bool)

    def each() -> Iterator[Frame]:
        for n in range(frames):
            values = sigma * random.normal(size=(side, side, 3))
            values[..., NORMAL] += touch * (n >= frames / 2) * (1 if quantity == "force" else -1)
            yield Frame(0, n / 100, n, values, valid)

    return FrameStream("noise", (array,), 2.4e6, frames, each())


def told(source: FrameStream, tare: str) -> list[Event]:
    found: list[Event] = []
    run(source, Settings(tare=tare), [lambda report: found.extend(report.events)])  # type: ignore[arg-type]  # one of two
    return found


@pytest.mark.parametrize("tare", ["off", "auto"])
@pytest.mark.parametrize("quantity", list(ON))
@pytest.mark.parametrize(("side", "frames"), [(2, 1000), (4, 1000), (8, 800), (32, 400), (128, 150)])
def test_noise_alone_makes_no_event(side: int, frames: int, quantity: Quantity, tare: str) -> None:
    """A quarter of the level of contact: of 16384 taxels some one is beyond it in every frame."""
    for seed in range(2):
        source = noise_of(side, quantity, ON[quantity] / 4, frames, np.zeros((side, side)), seed)
        assert [(event.kind, event.t) for event in told(source, tare)] == []


@pytest.mark.parametrize("side", [2, 16, 64])
def test_a_touch_of_a_few_taxels_is_felt(side: int) -> None:
    touch = np.zeros((side, side))
    touch[:2, :2] = 1.0
    found = told(noise_of(side, "force", ON["force"] / 4, 200, touch), "off")
    assert found[0].kind == "contact"
    assert found[0].t == pytest.approx(1.0, abs=0.02)
    assert sum(event.kind == "contact" for event in found) == 1


@pytest.mark.parametrize("taxels", [1, 4, 16, 64, 256, 1024, 16384])
def test_all_taxels_together_are_beyond_by_chance_as_seldom_as_a_few(taxels: int) -> None:
    noise = Noise(np.ones((1, taxels, 3)), np.ones((1, taxels, 3)), np.zeros((1, taxels), bool), np.ones(3))
    found = levels((1, taxels), "force", SIGMAS, None, None, noise)
    on = float(found.on[0, 0, NORMAL])
    assert taxels * norm.sf(on) <= FEW * norm.sf(2 * SIGMAS.contact) * 1.0001
    assert on == 2 * SIGMAS.contact if taxels <= FEW else 2 * SIGMAS.contact < on < 7
    assert (found.off[..., NORMAL] == SIGMAS.contact).all()


def test_two_frames_of_a_large_array_tell_its_noise() -> None:
    random = np.random.default_rng(1)
    first, second = random.normal(size=(2, 16, 16, 3)) * (1.0, 2.0, 4.0) + 100 * random.normal(size=(16, 16, 3))
    second[:5, :5] += 50.0  # pressed meanwhile
    found = early_noise(first, second)
    assert found is not None
    assert found[0, 0] == pytest.approx([1.0, 2.0, 4.0], rel=0.25)
    assert early_noise(first[:4, :4], second[:4, :4]) is None
