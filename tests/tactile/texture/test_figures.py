"""Friction and roughness over a window against rational arithmetic."""

from fractions import Fraction
from math import hypot, isqrt

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

from cnnsim.support import InputError
from tactile.texture.figures import Texture


def exactly(samples: list[float]) -> tuple[float, float]:
    """Return eqs (19) and (20), corrected, in rational numbers, with the root to 40 digits."""
    exact = [Fraction(sample) for sample in samples]
    mean = sum(exact) / len(exact)
    variance = sum((mean - sample) ** 2 for sample in exact) / (len(exact) - 1)
    if mean == 0:
        return 0.0, 0.0
    relative = variance / mean**2 * 10**4
    digits = 10**80
    return float(mean), float(Fraction(isqrt(int(relative * digits)), 10**40))


def frames(mu: NDArray[np.float64], normal: float = -2.0) -> NDArray[np.float64]:
    """Return frames (n, 1, 1, 3) with friction ``mu``, sheared along (3, 4) / 5."""
    return np.stack([-0.6 * mu * normal, 0.8 * mu * normal, np.full_like(mu, normal)], axis=-1)[:, None, None]


def friction_of(frame: NDArray[np.float64]) -> float:
    x, y, normal = frame[0, 0].tolist()
    return hypot(x, y) / float(abs(normal))


def check(stream: NDArray[np.float64], window: int, bound: float) -> None:
    texture = Texture(window, 0.0)
    for t, frame in enumerate(stream):
        figures = texture.update(frame)
        assert figures.valid[0, 0] == (t >= window - 1)
        if not figures.valid[0, 0]:
            assert np.isnan((figures.friction[0, 0], figures.roughness[0, 0])).all()
            continue
        friction, roughness = exactly([friction_of(f) for f in stream[t - window + 1 : t + 1]])
        assert figures.friction[0, 0] == pytest.approx(friction, rel=1e-14)
        assert figures.roughness[0, 0] == pytest.approx(roughness, rel=bound, abs=1e-12)


@settings(max_examples=40)
@given(st.integers(2, 9), st.lists(st.floats(0, 10).map(lambda v: round(v, 6)), min_size=1, max_size=40))
def test_random_series_match_rational_arithmetic(window: int, series: list[float]) -> None:
    check(frames(np.array(series)), window, 1e-9)


@pytest.mark.parametrize("offset", [0.3, 1e4, 1e8])
def test_mean_far_above_the_spread(offset: float) -> None:
    mu = offset + np.random.default_rng(1).normal(size=300) * 0.05
    check(frames(np.abs(mu)), 32, 1e-14 + 1e-13 * offset)


def test_a_burst_does_not_affect_later_windows() -> None:
    mu = 1 + np.random.default_rng(2).normal(size=200) * 1e-3
    mu[20:30] = 1e12
    stream = frames(mu)
    texture = Texture(16, 0.0)
    figures = [texture.update(frame) for frame in stream]
    for t in range(30 + 16, 200):  # the burst has left the window
        friction, roughness = exactly([friction_of(f) for f in stream[t - 15 : t + 1]])
        assert figures[t].friction[0, 0] == pytest.approx(friction, rel=1e-14)
        assert figures[t].roughness[0, 0] == pytest.approx(roughness, rel=1e-10)


@pytest.mark.parametrize("broken", [np.nan, np.inf, 1e-3, -1e-3, 0.0])
@pytest.mark.parametrize("at", [40, 47, 48])
def test_a_bad_reading_is_invalid_for_one_window(broken: float, at: int) -> None:
    stream = np.random.default_rng(3).uniform(1, 2, (100, 2, 3, 3))
    stream[at, 1, 2, 2] = broken
    texture, window = Texture(16, floor=1e-3), 16
    for t, frame in enumerate(stream):
        valid = texture.update(frame).valid
        assert valid[1, 2] == (t >= window - 1 and not at <= t < at + window)
        valid[1, 2] = t >= window - 1
        assert (valid == (t >= window - 1)).all()  # other taxels are unaffected


def test_scale_and_sign_of_the_normal_do_not_matter() -> None:
    mu = np.random.default_rng(5).uniform(0.2, 0.9, 20)
    forces, strains = Texture(8, 0.0), Texture(8, 0.0)
    for a, b in zip(frames(mu, 4.0), frames(mu, -(2.0**-20)), strict=True):
        one, other = forces.update(a), strains.update(b)
    assert one.friction == pytest.approx(other.friction, rel=1e-15)
    assert one.roughness == pytest.approx(other.roughness, rel=1e-13)


def test_wrong_input_is_refused() -> None:
    with pytest.raises(InputError, match="window of 1"):
        Texture(1, 0.0)
    with pytest.raises(InputError, match="floor nan"):
        Texture(4, float("nan"))
    texture = Texture(4, 0.0)
    texture.update(np.ones((2, 2, 3)))
    with pytest.raises(InputError, match=r"\(3, 3\) taxels after frames of \(2, 2\)"):
        texture.update(np.ones((3, 3, 3)))
    with pytest.raises(InputError, match=r"\(rows, cols, 3\)"):
        texture.update(np.ones((2, 2)))
