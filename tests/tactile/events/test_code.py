"""Codes: comparators as cells against a plain comparator, and the arithmetic of bits, characters and arrows."""

from unittest.mock import Mock

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
from tests.kits.paths import DATA as DATA_ROOT

DATA = DATA_ROOT / "papillarray"


def _schmitt(signal: np.ndarray, threshold: Threshold) -> np.ndarray:
    """The comparator written out, sample by sample: (n, ...) of -1, 0, +1."""
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
def test_comparator_cells_are_comparators(backend: str, seed: int, dead_band: float, part: float) -> None:
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
def test_cells_that_sleep_would_not_have_switched(seed: int, dead_band: float, part: float, step: float) -> None:
    """The program run on every frame against comparators that run it only when a cell may switch."""
    shear, contact = Threshold(dead_band, dead_band * part if part > 0.05 else 0.0), Threshold(dead_band / 2, dead_band)
    rng, always = np.random.default_rng(seed), UniversalMachine("cpu", "float64")
    cells = {"plus": shear.comparator(1), "minus": shear.comparator(-1), "press": contact.comparator()}
    program = load_program("event-code", templates=cells)
    comparators = Comparators(UniversalMachine("cpu", "float64"), (2, 3), shear, contact)
    walk = np.cumsum(rng.normal(size=(60, 2, 3, 3)), axis=0) * dead_band * step
    edges = np.array([0, dead_band, dead_band + shear.hysteresis, dead_band / 2, 1.5 * dead_band])
    walk[::7] = rng.choice([-1, 1], walk[::7].shape) * rng.choice(
        edges, walk[::7].shape
    )  # on the thresholds themselves
    before = comparators.code
    for i, values in enumerate(walk):
        planes = encode(Frame(0, i / 100, i, values, np.ones((2, 3), bool)), "force", shear, contact)
        out = always.run(program, **planes)
        assert comparators.update(np.array([*planes.values()])) == out["moved"]
        wanted = decode(out)
        for name in ("x", "y", "contact"):
            assert np.array_equal(getattr(comparators.code, name), getattr(wanted, name))
            assert np.array_equal(getattr(comparators.before, name), getattr(before, name))
        before = wanted


def test_cells_sleep_while_nothing_comes_near_a_threshold() -> None:
    machine = UniversalMachine("cpu", "float64")
    comparators = Comparators(machine, (1, 1), Threshold(1, 0.5), Threshold(1, 0.5))
    run = Mock(wraps=machine.run)
    machine.run = run  # type: ignore[method-assign]
    for n, level in enumerate([0.0, 1.4, -1.4, 1.6, 1.1, 9.0, 0.9, 1.4, 0.0]):
        values = np.full((1, 1, 3), [level, 0, 0])
        planes = encode(Frame(0, 0.0, n, values, np.ones((1, 1), bool)), "force", Threshold(1, 0.5), Threshold(1, 0.5))
        comparators.update(np.array([*planes.values()]))
    assert run.call_count == 2  # when 1.6 turns it on and 0.9 off
    assert comparators.code.arrows() == "·"


def test_the_bare_sign_holds_at_zero() -> None:
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


@pytest.mark.skipif(not DATA.is_dir(), reason="the recordings lie beside the project, and are not here")
def test_dead_band_calms_the_codes_of_real_grasps() -> None:
    """Corner pillars of both sensors: about 4 changes a second with the dead band, about 200 with bare signs."""
    calm, nervous, seconds, distinct = 0, 0, 0.0, []
    for path in sorted(DATA.glob("grasp_release*.npz")):
        with np.load(path) as recording:
            forces = [recording[f"s{s}_force"].astype(float) for s in (0, 1)]
            clocks = [recording[f"s{s}_t_ns"] * 1e-9 for s in (0, 1)]
        other = np.searchsorted(clocks[1], clocks[0]).clip(0, len(clocks[1]) - 1)
        shear = np.concatenate((forces[0], forces[1][other]), axis=1)
        shear = (shear - shear[:100].mean(axis=0))[:, [0, 2, 6, 8, 9, 11, 15, 17], :2]
        codes, signs = _machine_codes(shear, Threshold(0.1, 0.05)), shear.reshape(len(shear), -1) > 0
        calm += int((np.diff(codes, axis=0) != 0).any(axis=1).sum())
        nervous += int((np.diff(signs, axis=0) != 0).any(axis=1).sum())
        seconds += clocks[0][-1] - clocks[0][0]
        distinct.append(len(np.unique(codes, axis=0)))
    assert 3 < calm / seconds < 5
    assert 150 < nervous / seconds < 250
    assert np.median(distinct) <= 8


def _machine_codes(shear: np.ndarray, threshold: Threshold) -> np.ndarray:
    """Codes (n, 16) of shear (n, 8, 2) [N], by comparator cells of the machine."""
    comparators = {"plus": threshold.comparator(1), "minus": threshold.comparator(-1)}
    program, machine = load_program("event-code", templates=comparators), UniversalMachine("cpu", "float64")
    codes = []
    for i, sample in enumerate(shear):
        values = np.zeros((1, 8, 3))
        values[0, :, :2] = sample
        frame = Frame(0, 0.0, i, values, np.ones((1, 8), bool))
        code = decode(machine.run(program, **encode(frame, "force", threshold, threshold)))
        codes.append(np.concatenate((code.x, code.y)).ravel())
    return np.array(codes)
