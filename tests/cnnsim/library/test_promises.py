"""What the sentences of template files promise, where no formula says what must come out."""

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy import ndimage

from cnnsim.library.catalogue import run
from tests.kits.library import ANSWERS, SHAPES, pictures
from tests.oracles.pictures import CROSS, SQUARE, Case, Plane, black, plane


def block(shape: tuple[int, int], rows: slice, cols: slice) -> Plane:
    picture = -np.ones(shape)
    picture[rows, cols] = 1
    return picture


@pytest.mark.parametrize(
    ("name", "sign", "times", "extents"),
    [
        ("patch-maker", 1, (0.0, 4.0, 8.0, 12.0), (3, 7, 11, 15)),
        ("trigger-wave", 1, (0.0, 2.0, 4.0), (3, 9, 15)),
        ("trigger-wave-white", -1, (0.0, 2.0, 4.0), (3, 9, 15)),
    ],
)
def test_how_far_a_wave_runs(name: str, sign: int, times: tuple[float, ...], extents: tuple[int, ...]) -> None:
    start = sign * block((21, 21), slice(9, 12), slice(9, 12))
    found = [int((sign * run(name, start, duration=t, scheme="rk4", step=0.05).y[10] > 0).sum()) for t in times]
    assert found == list(extents)


@pytest.mark.parametrize("shape", SHAPES)
def test_waves_reach_all_they_can_reach(shape: tuple[int, int]) -> None:
    rng = np.random.default_rng(shape)
    walls = rng.random(shape) < 0.4
    start = plane((rng.random(shape) < 0.1) & ~walls)
    case = Case(x0=start, mask=walls)
    y = run("trigger-wave", start, mask=walls, duration="settled").y
    assert (y * ANSWERS["trigger-wave"](case) > 0.99).all()
    inverse = run("trigger-wave-white", -start, mask=walls, duration="settled").y
    assert np.array_equal(inverse, -y)
    assert (run("patch-maker", start, duration="settled").y * plane(start.max() > 0) > 0.99).all()


@pytest.mark.parametrize("name", ["small-object-remover", "averaging-threshold"])
@pytest.mark.parametrize("shape", SHAPES)
def test_repeated_majority_ends_where_every_cell_agrees_with_its_majority(name: str, shape: tuple[int, int]) -> None:
    voters, mode = (SQUARE, "constant") if name == "small-object-remover" else (CROSS, "nearest")
    for picture in pictures(name, shape):
        y = run(name, plane(picture)).y
        assert (np.abs(y) > 0.99).all()
        votes = ndimage.correlate(black(y).astype(int), voters.astype(int), mode=mode)
        assert np.array_equal(black(y), votes > voters.sum() / 2)


@pytest.mark.parametrize("size", [(1, 1), (2, 2), (3, 3), (1, 6), (6, 1)])
def test_small_objects_vanish_and_large_ones_stay(size: tuple[int, int]) -> None:
    small = block((14, 14), slice(4, 4 + size[0]), slice(4, 4 + size[1]))
    assert (run("small-object-remover", small).y < -0.99).all()
    y = run("small-object-remover", block((14, 14), slice(3, 11), slice(3, 11))).y
    assert black(y).sum() >= 64 - 4 * 3
    assert not black(y)[block((14, 14), slice(3, 11), slice(3, 11)) < 0].any()


def test_averaging_mends_noise_that_a_threshold_does_not() -> None:
    clean = block((16, 16), slice(4, 12), slice(4, 12))
    noisy = np.clip(0.5 * clean + np.random.default_rng(2).normal(0, 0.45, clean.shape), -1, 1)
    assert (noisy * clean < 0).sum() > 20
    assert (run("averaging-threshold", noisy).y * clean < 0).sum() <= 3


@pytest.mark.parametrize("length", range(1, 11))
@pytest.mark.parametrize("name", ["line-remover-7-vertical", "line-remover-7-horizontal"])
def test_lines_of_seven_pixels_go_and_longer_ones_keep_a_core(name: str, length: int) -> None:
    line = block((15, 7), slice(2, 2 + length), slice(3, 4))
    upright = name.endswith("vertical")
    y = black(run(name, line if upright else line.T).y)
    y = y if upright else y.T
    assert y.any() == (length > 7)
    assert not (y & (line < 0)).any()
    assert np.array_equal(y[2 : 2 + length], y[2 : 2 + length][::-1]), "the core is in the middle"


@pytest.mark.parametrize("length", range(1, 8))
@pytest.mark.parametrize("direction", [(0, 1), (1, 0), (1, 1), (1, -1)])
def test_lines_of_three_pixels_stay_and_longer_ones_go(length: int, direction: tuple[int, int]) -> None:
    picture = np.zeros((12, 12))
    for k in range(length):
        picture[2 + k * direction[0], (9 if direction[1] < 0 else 2) + k * direction[1]] = 1
    y = black(run("line-detector-3", picture).y)
    assert np.array_equal(y, picture > 0) if length <= 3 else not y.any()


@pytest.mark.parametrize("size", [(1, 1), (1, 5), (5, 1), (2, 2), (2, 6), (3, 4), (4, 7), (8, 8)])
def test_peeling_takes_one_pixel_from_each_side(size: tuple[int, int]) -> None:
    rows, cols = size
    picture = block((12, 12), slice(2, 2 + rows), slice(2, 2 + cols))
    peeled = block((12, 12), slice(3, max(3, 1 + rows)), slice(3, max(3, 1 + cols)))
    assert (run("peel-1-pixel", picture).y * peeled > 0.99).all()


@pytest.mark.parametrize("name", ["halftone-3x3", "halftone-5x5", "halftone-5x5-crounse"])
def test_halftones_are_binary_and_keep_the_local_mean(name: str) -> None:
    ramp = np.tile(np.linspace(-0.85, 0.85, 24), (16, 1))
    y = run(name, ramp, duration=60.0).y
    assert (np.abs(y) > 0.99).mean() > 0.95
    error = ndimage.gaussian_filter(y, 2.0) - ndimage.gaussian_filter(ramp, 2.0)
    assert np.abs(error)[4:-4, 4:-4].mean() < 0.1
    assert abs(y.mean()) < 0.05


def neighbours_alike(y: Plane) -> tuple[float, float]:
    """Mean products of horizontal and of vertical neighbours on the torus."""
    return float((y * np.roll(y, 1, axis=1)).mean()), float((y * np.roll(y, 1, axis=0)).mean())


@pytest.mark.parametrize(
    ("name", "signs"),
    [("checkerboard", (-1, -1)), ("stripes-vertical", (-1, 1)), ("stripes-horizontal", (1, -1))],
)
def test_patterns_grow_out_of_noise(name: str, signs: tuple[int, int]) -> None:
    noise = np.random.default_rng(11).normal(0, 0.05, (16, 16))
    y = run(name, noise).y
    assert (np.abs(y) > 0.99).all()
    assert all(sign * alike > 0.6 for sign, alike in zip(signs, neighbours_alike(y), strict=True))


def test_a_checkerboard_at_rest_has_at_most_two_neighbours_of_the_own_colour() -> None:
    noise: NDArray[np.float64] = np.random.default_rng(12).normal(0, 0.05, (14, 10))
    y = run("checkerboard", noise).y
    around = sum(np.roll(y, step, axis) for step in (1, -1) for axis in (0, 1))
    assert (y * around <= 0).all()
