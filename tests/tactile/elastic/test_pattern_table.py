"""Tables of load patterns against all their loads one by one, and the bends of splines that say how fine they are."""

import numpy as np
import pytest
from numpy.typing import NDArray

from tactile.elastic.layer_loads import layered_load
from tactile.elastic.medium import Felt, Medium
from tactile.elastic.pattern_loops import add_pattern
from tactile.elastic.pattern_table import PatternTable, step_of

KINDS = ("cap", "noise", "ring", "rim", "spots")


def image(kind: str, shape: tuple[int, int], random: np.random.Generator) -> NDArray[np.float64]:
    y, x = np.meshgrid(*(np.linspace(-1, 1, n) if n > 1 else np.zeros(1) for n in shape), indexing="ij")
    r = np.minimum(np.hypot(x, y), 1)
    noise = random.uniform(0, 1, shape)
    made = {
        "cap": np.sqrt(1.01 - r**2), "noise": noise, "ring": (r > 0.7) + 1e-9, "rim": 1 / np.sqrt(1.02 - r**2),
        "spots": (noise > 0.9) + 1e-9,
    }[kind]  # fmt: skip
    return np.asarray(made / made.sum())


@pytest.mark.parametrize("seed", range(12))
def test_a_table_is_all_loads_to_its_accuracy(seed: int) -> None:
    random = np.random.default_rng(seed)
    wide = float(10 ** random.uniform(-1.3, 1.0))  # depths
    shape = int(random.integers(1, 14)) + int(2 * wide), int(random.integers(1, 14)) + int(2 * wide)
    pitch = wide / max(shape)
    shares = image(KINDS[seed % len(KINDS)], shape, random)
    thickness = (1.0, 1.1, 2.0, 5.0, np.inf)[seed % 5]
    quantity: Felt = ("strain", "stress")[seed % 2]
    nu, accuracy = random.choice([0.5, 0.3, 0.0]), (1e-3, 1e-4, 1e-5)[seed % 3]
    middle = random.uniform(-1, 1, 2)
    table = PatternTable(
        shares, (float(middle[0]), float(middle[1])), pitch, 1 / thickness, nu, quantity, accuracy, (3, 8)[seed % 4 > 0]
    )
    table.reach(25.0)
    y, x = np.meshgrid(*((np.arange(n) - (n - 1) / 2) * pitch for n in shape), indexing="ij")
    at = np.concatenate([random.uniform(-far, far, (150, 2)) for far in (0.5, wide / 2 + 1, wide / 2 + 5, 25)])
    for force in range(2 if table.columns == 3 else 0, 3):
        loads = np.zeros((x.size, 5))
        loads[:, 0], loads[:, 1], loads[:, 2 + force] = x.ravel() + middle[0], y.ravel() + middle[1], shares.ravel()
        wanted = layered_load(at, 1.0, loads, Medium(1.0, nu, quantity, thickness))
        row, got = np.zeros((2, 5)), np.zeros((2, len(at), 3))
        row[:, 2 + force] = 1.0, 9.0
        add_pattern(got, at, row, np.array([0]), np.array([1.0]), table.numbers, table.grids, table.columns)
        assert not got[1].any()  # of the frames that are named alone
        off = np.abs(got[0] - wanted)
        assert off.max() <= accuracy * np.abs(wanted).max()
        beside = np.abs(at - middle).max(axis=1) > wide / 2 + 2.5  # taxels may lie beside what presses
        assert off[beside].max() <= 2 * accuracy * max(np.abs(wanted[beside]).max(), 0.01 * np.abs(wanted).max())


def test_a_step_is_what_the_accuracy_asks_for() -> None:
    steps = [step_of(0.5, 0.5, "strain", accuracy) for accuracy in (1e-4, 1e-5, 1e-6)]
    assert steps[0] / steps[1] == pytest.approx(10**0.25)  # a cubic's error is of the fourth order
    shares, at = np.ones((1, 1)), np.random.default_rng(0).uniform(-1, 1, (400, 2))
    wanted = layered_load(at, 1.0, np.array([[0, 0, 0, 0, 1.0]]), Medium(1.0, 0.5, "strain", 2.0))
    for accuracy in (1e-4, 1e-5, 1e-6):  # under a single load the bound is used, not idle
        table, got = PatternTable(shares, (0.0, 0.0), 1.0, 0.5, 0.5, "strain", accuracy, 3), np.zeros((1, 400, 3))
        table.reach(2.0)
        row = np.array([[0, 0, 0, 0, 1.0]])
        add_pattern(got, at, row, np.array([0]), np.array([1.0]), table.numbers, table.grids, 3)
        assert 0.2 * accuracy < np.abs(got[0] - wanted).max() / np.abs(wanted).max() < accuracy


def test_a_layer_feels_nothing_far_away_and_a_half_space_does() -> None:
    for ratio, felt in ((1.0, False), (0.0, True)):
        table, out = PatternTable(np.ones((1, 1)), (0.0, 0.0), 1.0, ratio, 0.5, "strain", 1e-4, 3), np.zeros((1, 1, 3))
        table.reach(1e5)
        row = np.array([[0, 0, 0, 0, 1.0]])
        add_pattern(out, np.array([[9e4, 0.0]]), row, np.array([0]), np.array([1.0]), table.numbers, table.grids, 3)
        assert out.any() == felt
        known = layered_load(np.array([9e4, 0.0]), 1.0, row, Medium(1.0, 0.5, thickness=1.0 if ratio else np.inf))
        assert out[0, 0] == pytest.approx(known, rel=1e-3, abs=1e-30)
