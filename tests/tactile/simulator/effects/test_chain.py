"""Effects together: each acts on what the ones before it left, in the order of a real chain, written down by hand."""

import numpy as np
import pytest
from numpy.typing import NDArray

from tactile.core.frame import TaxelArray
from tactile.simulator.contacts.moving_load import MovingLoad
from tactile.simulator.effects import ORDER, make_effect
from tactile.simulator.scene.scene import Scene

RATE, SHAPE = 200.0, (2, 3)
PAD = TaxelArray("pad", *SHAPE, 1e-3, 1e-3)
SCALE, TAU, SLOT, STEP = 0.1, 4e-3, 2e-4, 0.25 * 0.1 / 2**9


def scene(*names: str) -> Scene:
    rows = [
        (0.0, -1e-3, 0, 0.02, 0, 0.1),
        (0.4, 0, 0, 0.04, 0.01, 0.5),
        (0.41, 0, 0, 0, 0, 0.0),
        (1.0, 1e-3, 0, 0, 0, 0.3),
    ]
    parameters = {
        "crosstalk": {"cross_axis": 0.03, "neighbour": 0.02},
        "temperature": {"start": 1.0, "change": 4.0, "time": 0.3, "gain": -0.02, "offset": 0.004},
        "clipping": {"limit": 0.4},
        "low_pass": {"time": TAU},
        "multiplex_skew": {"slot": SLOT},
        "quantisation": {"bits": 10, "span": 0.25},
    }
    effects = [make_effect(name, **parameters[name]) for name in names]
    return Scene("s", RATE, 1.0, 2.4e6, [PAD], [MovingLoad(0, rows)], effects=effects, full_scale=SCALE)


def values(given: Scene) -> NDArray[np.float64]:
    return np.concatenate([batch.values for batch in given.batches(0)])


def mixed(x: NDArray[np.float64]) -> NDArray[np.float64]:
    """Components, then neighbours, one entry after the other."""
    y, z = np.empty_like(x), np.empty_like(x)
    for c in range(3):
        y[..., c] = x[..., c] + 0.03 * (x[..., (c + 1) % 3] + x[..., (c + 2) % 3])
    for row, col in np.ndindex(*SHAPE):
        z[:, row, col] = y[:, row, col]
        for r, c in ((row - 1, col), (row + 1, col), (row, col - 1), (row, col + 1)):
            if 0 <= r < SHAPE[0] and 0 <= c < SHAPE[1]:
                z[:, row, col] += 0.02 * y[:, r, c]
    return z


def warm(x: NDArray[np.float64]) -> NDArray[np.float64]:
    kelvin = 1.0 + 4.0 * (1 - np.exp(-np.arange(len(x)) / RATE / 0.3))[:, None, None, None]
    return np.asarray(x * (1 - 0.02 * kelvin) + 0.004 * SCALE * kelvin)


def filtered(x: NDArray[np.float64]) -> NDArray[np.float64]:
    """tau dy/dt = x - y on straight pieces of x, by the formula for a ramp."""
    y, dt = x.copy(), 1 / RATE
    for n in range(1, len(x)):
        slope = (x[n] - x[n - 1]) / dt
        # y = x - tau slope is a particular solution
        y[n] = x[n] - TAU * slope + (y[n - 1] - x[n - 1] + TAU * slope) * np.exp(-dt / TAU)
    return y


def skewed(x: NDArray[np.float64]) -> NDArray[np.float64]:
    flat, t = x.reshape(len(x), -1), np.arange(len(x)) / RATE
    late = SLOT * np.arange(flat.shape[1])[::-1]
    # what would be read before the frame before, is read with it; before the first frame there is none
    return np.stack(
        [
            np.interp(np.maximum(t - by, np.maximum(t - 1 / RATE, 0)), t, one)
            for by, one in zip(late, flat.T, strict=True)
        ],
        axis=1,
    ).reshape(x.shape)


def test_the_chain_of_a_real_array_by_hand() -> None:
    """The amplifier's rails, the filter behind it, the multiplexer, and the converter at last."""
    ideal = values(scene())
    clipped = np.clip(warm(mixed(ideal)), -0.4 * SCALE, 0.4 * SCALE)
    assert (np.abs(clipped) == 0.4 * SCALE).any()
    wanted = np.clip(np.rint(skewed(filtered(clipped)) / STEP), -512, 511) * STEP
    names = ("quantisation", "multiplex_skew", "low_pass", "clipping", "temperature", "crosstalk")  # in any order
    found = values(scene(*names))
    apart = np.abs(found - wanted)
    assert apart.max() < STEP * 1.001  # a reading on a step's edge may fall to either side
    assert np.count_nonzero(apart > 1e-9 * STEP) < 1e-3 * apart.size
    # and none of these may change places: each pair the other way round is another reading
    for one, other in (("clipping", "low_pass"), ("multiplex_skew", "quantisation"), ("low_pass", "quantisation")):
        assert ORDER.index(one) < ORDER.index(other)
    rails = np.clip(skewed(filtered(warm(mixed(ideal)))), -0.4 * SCALE, 0.4 * SCALE)
    assert np.abs(rails - skewed(filtered(clipped))).max() > 20 * STEP


@pytest.mark.parametrize("name", ("crosstalk", "temperature", "clipping", "low_pass", "multiplex_skew"))
def test_each_link_by_hand(name: str) -> None:
    ideal = values(scene())
    by_hand = {
        "crosstalk": mixed(ideal),
        "temperature": warm(ideal),
        "clipping": np.clip(ideal, -0.4 * SCALE, 0.4 * SCALE),
        "low_pass": filtered(ideal),
        "multiplex_skew": skewed(ideal),
    }
    assert values(scene(name)) == pytest.approx(by_hand[name], rel=1e-9, abs=1e-12)
    assert np.abs(by_hand[name] - ideal).max() > 1e-4
