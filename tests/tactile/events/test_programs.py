"""Programs on taxel grids of 1 x 1 to 16 x 16 against loops, labels and finite differences."""

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy import ndimage

from tests.kits.program_cases import (
    BACKENDS,
    TINY,
    Draw,
    Planes,
    check,
    check_frames,
    few,
    gray,
    machine,
    picture,
    planes,
    program,
)
from tests.oracles import touch_programs as oracle

SHEAR: dict[str, Draw] = {"shear_x": gray, "shear_y": gray}
FRAME: dict[str, Draw] = {**SHEAR, "pressing": gray}
CASES: dict[str, tuple[dict[str, Draw], Callable[..., Any]]] = {
    "contact-blob": ({"pressing": gray}, oracle.contact_blob),
    "shear-flow": (SHEAR, oracle.shear_flow),
    "coherent-shear": (FRAME, oracle.coherent_shear),
    "onset-wave": ({"contact": picture, "onset": few}, oracle.onset_wave),
}


@pytest.mark.parametrize("backend", BACKENDS)
@pytest.mark.parametrize("name", CASES)
@given(data=st.data())
def test_program(backend: str, name: str, data: st.DataObject) -> None:
    kinds, answer = CASES[name]
    check(backend, name, data.draw(planes(kinds, longest=16)), answer)


@pytest.mark.parametrize("backend", BACKENDS)
@pytest.mark.parametrize("name", CASES)
def test_program_on_the_smallest_arrays(backend: str, name: str) -> None:
    kinds, answer = CASES[name]
    for shape in (*TINY, (16, 16)):
        for seed in range(4):
            rng = np.random.default_rng(seed)
            check(backend, name, {key: kind(rng, shape) for key, kind in kinds.items()}, answer)


@pytest.mark.parametrize("votes", range(1, 10))
@settings(max_examples=20)
@given(frame=planes(FRAME, longest=8))
def test_votes(votes: int, frame: Planes) -> None:
    check("cpu", "coherent-shear", frame, oracle.coherent_shear, votes=votes, dead_band=0.125, level=-0.5)


def _sequence(seed: int, shape: tuple[int, int]) -> list[Planes]:
    """Return five frames that change by at most a quarter of full scale, often within the hysteresis."""
    rng = np.random.default_rng(seed)
    frame = {name: kind(rng, shape) for name, kind in FRAME.items()}
    frames = [frame]
    for _ in range(4):
        frame = {name: np.clip(plane + rng.integers(-16, 17, shape) / 64, -1, 1) for name, plane in frame.items()}
        frames.append(frame)
    return frames


@pytest.mark.parametrize("backend", BACKENDS)
def test_slip_front(backend: str) -> None:
    """25 sequences of five frames, and the smallest arrays."""
    for seed in range(25):
        shape = tuple(int(n) for n in np.random.default_rng(seed).integers(1, 17, 2))
        check_frames(backend, "slip-front", _sequence(seed, (shape[0], shape[1])), oracle.slip)
    for shape in TINY:
        check_frames(backend, "slip-front", _sequence(1, shape), oracle.slip)


def test_slip_front_of_a_slipping_rim() -> None:
    """A disc is pressed and sheared to the right; then its rim slips and the core sticks."""
    i, j = np.indices((9, 9)) - 4
    disc, core = i**2 + j**2 <= 16, i**2 + j**2 <= 4
    pressing, still = np.where(disc, 1.0, -1.0), np.zeros((9, 9))
    machine("cpu").reset()
    landed = machine("cpu").run(program("slip-front"), shear_x=np.where(disc, 0.8, 0), shear_y=still, pressing=pressing)
    assert not landed["slipping"]
    assert np.array_equal(landed["stuck"], disc)
    after = machine("cpu").run(program("slip-front"), shear_x=np.where(core, 0.8, 0), shear_y=still, pressing=pressing)
    assert np.array_equal(after["slid"], disc & ~core)
    assert np.array_equal(after["stuck"], core)
    assert np.array_equal(after["front"], ndimage.binary_dilation(core, np.ones((3, 3))) & disc & ~core)


def test_spreading_and_twist() -> None:
    """Radial shear has divergence only, circular shear has curl only."""
    y, x = (np.indices((7, 7)) - 3) / 8
    spread = machine("cpu").run(program("shear-flow"), shear_x=x, shear_y=y)
    twist = machine("cpu").run(program("shear-flow"), shear_x=-y, shear_y=x)
    inner = (slice(1, -1), slice(1, -1))
    assert (spread["divergence"][inner] == 0.25).all()
    assert (spread["curl"] == 0).all()
    assert (twist["curl"][inner] == 0.25).all()
    assert (twist["divergence"] == 0).all()
    assert twist["clockwise"].all()
    assert not twist["anticlockwise"].any()


@pytest.mark.parametrize("backend", BACKENDS)
@pytest.mark.parametrize("shape", [(1, 1), (2, 3), (4, 1, 5), (7, 8, 8)])
def test_comparators_switch_with_hysteresis(backend: str, shape: tuple[int, ...]) -> None:
    """Signals in steps of 1/8 do not coincide with the thresholds 1/6 and 1/4."""
    runs, on = machine(backend), np.zeros(shape, bool)
    rng = np.random.default_rng(len(shape))
    for _ in range(20):
        signal = rng.integers(-8, 9, shape) / 8 + 1 / 16
        on = np.where(signal > 1 / 4, True, np.where(signal < 1 / 6, False, on))
        out = runs.run(program("comparators"), signal=signal)
        assert np.array_equal(out["on"] > 0, on)
