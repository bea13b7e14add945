"""Codes: comparator cells against a plain Schmitt trigger; bits, characters and arrows of a code."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from cnnsim import InputError, run_transient
from cnnsim.program.file import load_program
from cnnsim.program.machine import UniversalMachine
from tactile.core.frame import Frame
from tactile.events.code import Code, decode, encode, hand_code
from tactile.events.comparators import Comparators
from tactile.thresholds.threshold import SIGN, Threshold


def _schmitt(signal: np.ndarray, threshold: Threshold) -> np.ndarray:
    """Return the outputs (n, ...) of a Schmitt trigger with both signs: -1, 0, +1."""
    high, low = threshold.dead_band + threshold.hysteresis, threshold.dead_band
    on = {+1: np.zeros(signal.shape[1:], bool), -1: np.zeros(signal.shape[1:], bool)}
    out = np.empty(signal.shape, int)
    for i, sample in enumerate(signal):
        for way in on:
            rising, falling = way * sample > high, way * sample < low
            on[way] = (on[way] | rising) & ~(falling & ~rising)
        out[i] = on[+1].astype(int) - on[-1].astype(int)
    return out


@pytest.mark.parametrize("backend", ["reference", "cpu"])
@settings(max_examples=30)
@given(seed=st.integers(0, 2**32), dead_band=st.floats(1e-4, 5), part=st.floats(0, 2))
def test_comparator_cells_match_a_schmitt_trigger(backend: str, seed: int, dead_band: float, part: float) -> None:
    threshold = Threshold(dead_band, dead_band * part if part > 0.05 else 0.0)
    rng = np.random.default_rng(seed)
    values = np.zeros((25, 2, 3, 3))
    values[..., :2] = np.cumsum(rng.normal(size=(25, 2, 3, 2)), axis=0) * dead_band
    program = load_program(
        "event-code",
        templates={"plus": threshold.comparator(1), "minus": threshold.comparator(-1), "press": threshold.comparator()},
    )
    machine = UniversalMachine(backend, "float64")
    wanted = _schmitt(values[..., :2], threshold)
    before = Code(np.zeros((2, 3), np.int8), np.zeros((2, 3), np.int8), np.zeros((2, 3), bool))
    for i, sample in enumerate(values):
        frame = Frame(0, i / 100, i, sample, np.ones((2, 3), bool))
        planes = machine.run(program, **encode(frame, "force", threshold, threshold))
        code = decode(planes)
        assert np.array_equal(code.x, wanted[i, ..., 0])
        assert np.array_equal(code.y, wanted[i, ..., 1])
        assert bool(planes["moved"]) == (not np.array_equal((code.x, code.y), (before.x, before.y)))
        before = code


@settings(max_examples=40)
@given(seed=st.integers(0, 2**32), dead_band=st.floats(1e-4, 5), part=st.floats(0, 2), step=st.floats(0.02, 1))
def test_comparators_that_skip_runs_match_a_schmitt_trigger(
    seed: int, dead_band: float, part: float, step: float
) -> None:
    """`Comparators` runs its program only when a cell may switch."""
    shear, contact = Threshold(dead_band, dead_band * part if part > 0.05 else 0.0), Threshold(dead_band / 2, dead_band)
    rng = np.random.default_rng(seed)
    comparators = Comparators(UniversalMachine("cpu", "float64"), (2, 3), shear, contact)
    walk = np.cumsum(rng.normal(size=(60, 2, 3, 3)), axis=0) * dead_band * step
    edges = np.array([0, dead_band, dead_band + shear.hysteresis, dead_band / 2, 1.5 * dead_band])
    near = np.concatenate([edges * (1 - 1e-9), edges * (1 + 1e-9)])
    walk[::7] = rng.choice([-1, 1], walk[::7].shape) * rng.choice(near, walk[::7].shape)
    wanted = {"x": _schmitt(walk[..., 0], shear), "y": _schmitt(walk[..., 1], shear),
              "contact": _schmitt(walk[..., 2], contact) > 0}  # fmt: skip
    before = dict.fromkeys(wanted, np.zeros((2, 3)))
    for i, values in enumerate(walk):
        planes = encode(Frame(0, i / 100, i, values, np.ones((2, 3), bool)), "force", shear, contact)
        moved = comparators.update(np.array([*planes.values()]))
        now = {name: course[i] for name, course in wanted.items()}
        assert moved == any(not np.array_equal(now[name], before[name]) for name in wanted)
        for name in wanted:
            assert np.array_equal(getattr(comparators.code, name), now[name])
            assert np.array_equal(getattr(comparators.before, name), before[name])
        before = now


def test_the_sign_code_keeps_its_state_at_zero() -> None:
    cell = SIGN.comparator()
    for state in (-1.0, 1.0):
        held = run_transient(cell, state=[[state, state, state]], input=[[-1e-9, 0.0, 1e-9]])
        assert held.y.tolist() == [[-1.0, state, 1.0]]


def test_codes_as_bits_characters_and_arrows() -> None:
    x, y = np.array([[1, -1], [0, 1]], np.int8), np.array([[0, -1], [1, 0]], np.int8)
    code = Code(x, y, x > 0)
    assert code.ternary() == "+0--0++0"
    assert code.arrows() == "→↖ ↓→"
    assert code.signs() == 0b10000110
    other = Code(-x, -y, x > 0)
    assert hand_code([code, other]) == 0b10000110_00110000
    wide = Code(np.ones((8, 8), np.int8), np.zeros((8, 8), np.int8), np.ones((8, 8), bool))
    assert hand_code([wide, wide]) == int("10" * 128, 2)


def test_invalid_and_not_finite_taxels_have_no_code() -> None:
    values = np.full((2, 2, 3), 9.0)
    values[0, 0, 0], values[1, 1, 2] = np.nan, np.inf
    valid = np.array([[True, False], [True, True]])
    planes = encode(Frame(0, 0.0, 0, values, valid), "force", Threshold(1, 0.5), Threshold(1, 0.5))
    assert planes["shear_x"].tolist() == [[0, 0], [1, 1]]
    assert planes["shear_y"].tolist() == [[1, 0], [1, 1]]
    assert planes["pressing"].tolist() == [[1, 0], [1, 0]]
    strain = encode(Frame(0, 0.0, 0, values, valid), "strain", Threshold(1, 0.5), Threshold(1, 0.5))
    assert strain["pressing"].tolist() == [[-1, 0], [-1, 0]]


@pytest.mark.parametrize("numbers", [(-1, 0), (0, -1), (np.nan, 0), (0, np.inf)])
def test_a_bad_threshold_is_refused(numbers: tuple[float, float]) -> None:
    with pytest.raises(InputError, match="a number from 0 wanted"):
        Threshold(*numbers)
