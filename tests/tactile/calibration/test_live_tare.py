"""Tares of arriving frames: their times, the tared readings, and the measured noise."""

import warnings
from typing import Any

import numpy as np
import pytest

from tactile.calibration.gains import Gains
from tactile.calibration.live_tare import LiveTare
from tactile.core.frame import Frame, TaxelArray
from tactile.core.noise import measured

ARRAY = TaxelArray("tip", 1, 2, 1e-3, 1e-3, quantity="strain")
PAD = TaxelArray("pad", 3, 3, 7e-3, 0.0, quantity="force")


def fed(tare: LiveTare, values: np.ndarray, start: int = 0) -> list[Frame]:
    return [tare(Frame(0, 0.01 * (start + n), start + n, v, np.ones(v.shape[:2], bool))) for n, v in enumerate(values)]


def noise(sigma: float, frames: int = 21, seed: int = 3) -> np.ndarray:
    return sigma * np.random.default_rng(seed).standard_normal((frames, 3, 3, 3))


def test_tare_at_the_start_idle_and_never_while_loaded() -> None:
    rng = np.random.default_rng(3)

    def held(level: float, n: int = 21, size: float = 1e-5) -> np.ndarray:
        return 0.5 + level + size * rng.standard_normal((n, 1, 2, 3))

    tare = LiveTare(0, ARRAY)
    assert not any(frame.valid.any() for frame in fed(tare, held(0.0)[:20]))
    (first,) = fed(tare, held(0.0, 1), 20)
    assert np.abs(first.values).max() < 1e-4
    fed(tare, held(2e-4), 21)  # drift, well below half a dead band
    assert [note.why for note in tare.notes] == ["at the start", "idle"]
    assert "subtracted" in tare.notes[0].detail
    known = len(tare.notes)
    loaded = fed(tare, held(-0.01, 210), 42)  # a constant load is not drift
    assert len(tare.notes) == known
    assert np.abs(loaded[-1].values + 0.0102).max() < 1e-4
    tare.ask()
    fed(tare, held(-0.01), 252)
    assert (tare.notes[-1].why, tare.notes[-1].offset) == ("refused: loaded", None)
    assert "off the tare: let nothing touch it, then ask for a tare" in tare.notes[-1].detail
    tare.ask(force=True)
    fed(tare, held(-0.01), 273)
    assert tare.notes[-1].why == "by force"
    manual = LiveTare(0, ARRAY, "manual")
    fed(manual, held(0.0))
    fed(manual, held(1e-4), 21)
    assert [note.why for note in manual.notes] == ["at the start"]


def test_the_first_tare_waits_for_stillness() -> None:
    tare = LiveTare(0, ARRAY)
    moving = np.linspace(0, 0.01, 21)[:, None, None, None] * np.ones((1, 1, 2, 3))
    assert not fed(tare, moving)[-1].valid.any()
    assert tare.notes[-1].why == "refused: moving"
    still = np.full((21, 1, 2, 3), 0.0)
    still[:, 0, 1] = np.nan  # a taxel without readings does not delay it
    last = fed(tare, still, 21)[-1]
    assert last.valid.tolist() == [[True, False]]
    assert np.abs(last.values[0, 0]).max() < 1e-15


@pytest.mark.parametrize(
    ("frames", "onset", "taxels"),
    [
        (84, ([10, 20], [0, 1]), 3),  # the finger closes during the first block and holds still
        (63, ([8, 20, 21, 41], [0, 3, 3, 1.4]), 2),  # an overshoot within a block is not noise
    ],
)
def test_a_load_before_the_first_tare_is_not_subtracted(frames: int, onset: Any, taxels: int) -> None:
    tare = LiveTare(0, PAD)
    values = noise(2e-3, frames)
    values[:, :taxels, :taxels, 2] += np.interp(np.arange(frames), *onset)[:, None, None]
    fed(tare, values)
    assert {note.why for note in tare.notes} == {"refused: moving", "refused: loaded"}


@pytest.mark.parametrize("sigma", [1e-3, 0.04, 0.2])
def test_noise_alone_is_neither_motion_nor_load(sigma: float) -> None:
    tare = LiveTare(0, PAD)
    fed(tare, noise(sigma, 84))
    assert tare.notes[0].why == "at the start"
    assert tare.noise is not None
    assert tare.noise.sigma == pytest.approx(np.full((3, 3, 3), sigma), rel=0.9)


def test_a_pad_tared_under_load_has_another_zero_once_it_is_free() -> None:
    """By itself in mode auto; on request in mode manual, which reports it."""
    tare, manual = LiveTare(0, PAD), LiveTare(0, PAD, "manual")
    for one in (tare, manual):
        fed(one, noise(2e-3) + np.array([0, 0, 1.0]))
        free = fed(one, noise(2e-3, 84), 21)[-1]
        assert (np.abs(free.values).max() < 0.02) == (one is tare)
    note = tare.notes[1]
    assert (note.why, note.notice, tare.moved) == ("the zero moved at 0.210 s", True, 0.21)
    assert note.detail.startswith("-9.00 N normal, 0.00 N shear")
    (_, note) = manual.notes
    assert note.why == "refused: loaded"
    assert "it was pressed during the tare; t! tares it by force" in note.detail
    manual.ask(force=True)
    free = fed(manual, noise(2e-3, 22), 105)[-1]
    assert np.abs(free.values).max() < 0.02


def test_noisy_and_dead_taxels_are_named() -> None:
    block = noise(2e-3, 100)
    block[:, 0, 1] *= 20
    block[:, 2, 2] = 0.25
    found = measured(block)
    assert found.words() == ["taxel (0, 1) is noisy, left out", "taxel (2, 2) is dead, left out"]
    assert found.left_out.sum() == 2
    assert not measured(noise(2e-3, 100)).left_out.any()
    assert not measured(np.zeros((20, 3, 3, 3))).left_out.any()  # an array without noise is not dead


def test_gains_do_not_change_the_verdicts() -> None:
    gains = Gains(2.0**-10, -(2.0**-6))
    for values, why in ((noise(1e-4), "at the start"), (np.linspace(0, 1, 21)[:, None, None, None], "refused: moving")):
        given = np.broadcast_to(values, (21, 3, 3, 3))[:, :1, :2]
        plain, scaled = LiveTare(0, ARRAY), LiveTare(0, ARRAY, gains=gains)
        fed(plain, given)
        fed(scaled, given / gains(np.ones(3)))
        assert [note.why for note in plain.notes] == [note.why for note in scaled.notes] == [why]


@pytest.mark.parametrize(
    ("pull", "why"), [((0, 0, -1), "at the start"), ((0, 1, 0), "at the start"), ((0, 0, 1), "refused: moving")]
)
def test_a_creeping_pillar_is_left_out_and_a_touched_one_prevents_the_tare(pull: Any, why: str) -> None:
    block = noise(2e-3)
    block[:, 0, 2] += 0.3 * np.multiply.outer(np.linspace(0, 1, len(block)), pull)
    tare = LiveTare(0, PAD)
    fed(tare, block)
    assert [note.why for note in tare.notes] == [why]
    if why == "at the start":
        assert tare.noise is not None
        assert np.argwhere(tare.noise.left_out).tolist() == [[0, 2]]


def test_infinite_readings_cause_no_offset_and_no_warning() -> None:
    values = noise(1e-3, 60)
    values[:, 2, 2, 0] = np.inf
    tare = LiveTare(0, PAD)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        frames = fed(tare, values)
    assert frames[-1].valid.sum() == 8
    assert not frames[-1].valid[2, 2]
    assert tare.notes[0].offset is not None
    assert not np.isinf(tare.notes[0].offset).any()


def slow_noise(rng: np.random.Generator, frames: int, sigma: float) -> np.ndarray:
    """Return noise with a correlation of about 25 frames and little jitter."""
    white = rng.standard_normal((frames + 200, 3, 3, 3))
    weight = np.exp(-np.arange(200) / 25)
    smooth = np.apply_along_axis(np.convolve, 0, white, weight / np.linalg.norm(weight), "valid")[:frames]
    return np.asarray(sigma * (smooth + 0.05 * rng.standard_normal(smooth.shape)))


def at_500_hz(tare: LiveTare, values: np.ndarray) -> list[Frame]:
    return [tare(Frame(0, 0.002 * n, n, v, np.ones(v.shape[:2], bool))) for n, v in enumerate(values)]


@pytest.mark.parametrize("scale", [0.25, 1.0, 4.0, 16.0])
def test_slow_noise_is_neither_motion_nor_load_but_a_load_of_its_size_is(scale: float) -> None:
    taken = 0
    for seed in range(12):
        values = slow_noise(np.random.default_rng(seed), 101, 0.01 * scale)
        tare = LiveTare(0, PAD)
        at_500_hz(tare, values)
        taken += tare.notes[0].why == "at the start"
        values[:, 1, 1:, 2] += scale * np.linspace(0, 2, 101)[:, None]  # a growing load on two taxels of nine
        tare = LiveTare(0, PAD)
        at_500_hz(tare, values)
        assert tare.notes[0].why in {"refused: moving", "at the start"}
        if tare.notes[0].offset is not None:  # from the frames before the load was detectable
            assert np.abs(tare.notes[0].offset[1, 1:, 2]).max() < 0.6 * scale
    assert taken >= 11


@pytest.mark.parametrize("onset", [0.08, 0.12, 0.17])
def test_the_tare_uses_the_frames_before_an_early_load(onset: float) -> None:
    rng = np.random.default_rng(5)
    t = 0.002 * np.arange(300)
    values = 0.003 * rng.standard_normal((300, 3, 3, 3)) + 0.4
    values[..., 2] += np.clip((t - onset) / 0.05, 0, 1)[:, None, None]
    tare = LiveTare(0, PAD)
    frames = at_500_hz(tare, values)
    assert tare.notes[0].why == "at the start"
    assert tare.notes[0].t < onset + 0.025
    assert np.abs(frames[-1].values - np.array([0, 0, 1.0])).max() < 0.02
