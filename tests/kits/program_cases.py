"""Random pictures for the programs, and the comparison of a program with its oracle on one backend."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import cache
from typing import Any

import numpy as np
import numpy.typing as npt
import pytest
from hypothesis import strategies as st

from cnnsim import backends
from cnnsim.program.file import load_program
from cnnsim.program.machine import UniversalMachine
from cnnsim.program.program import Program

Planes = dict[str, npt.NDArray[Any]]
Shape = tuple[int, int]

BACKENDS = backends.NAMES
TINY: tuple[Shape, ...] = ((1, 1), (1, 2), (2, 1), (2, 2), (1, 9), (9, 1))


def _noise(rng: np.random.Generator, shape: Shape) -> npt.NDArray[Any]:
    return rng.random(shape) < rng.choice([0, 0.15, 0.4, 0.6, 0.85, 1])


def picture(rng: np.random.Generator, shape: Shape) -> npt.NDArray[Any]:
    """Noise of some density, or a few rectangles, one over the other or cutting holes into each other."""
    if rng.random() < 0.4:
        return _noise(rng, shape)
    drawn, cutting = np.zeros(shape, dtype=bool), rng.random() < 0.5
    for _ in range(rng.integers(1, 6)):
        (i, j), (height, width) = rng.integers(0, shape), rng.integers(1, 9, 2)
        drawn[i : i + height, j : j + width] = ~drawn[i : i + height, j : j + width] if cutting else True
    return drawn


def few(rng: np.random.Generator, shape: Shape) -> npt.NDArray[Any]:
    """Some black cells, or none."""
    return rng.random(shape) < rng.choice([0, 0.05, 0.2])


def cell(rng: np.random.Generator, shape: Shape) -> npt.NDArray[Any]:
    """One black cell."""
    drawn = np.zeros(shape, dtype=bool)
    drawn.flat[rng.integers(drawn.size)] = True
    return drawn


def gray(rng: np.random.Generator, shape: Shape) -> npt.NDArray[Any]:
    """Noise, or a ramp, of multiples of 1/64: sums and differences of a few are exact in any precision."""
    if rng.random() < 0.5:
        return rng.integers(-64, 65, shape) / 64
    i, j = np.indices(shape)
    slope = rng.integers(-16, 17, 2)
    return np.clip(slope[0] * i + slope[1] * j + rng.integers(-32, 33), -64, 64) / 64


def coarse(rng: np.random.Generator, shape: Shape) -> npt.NDArray[Any]:
    """Noise of multiples of 1/8, the gray levels of the program rank-order."""
    return rng.integers(-8, 9, shape) / 8


Draw = Callable[[np.random.Generator, Shape], npt.NDArray[Any]]


@st.composite
def planes(draw: st.DrawFn, kinds: Mapping[str, Draw], longest: int = 10) -> Planes:
    """Planes of one shape, from 1 x 1 up."""
    shape = draw(st.integers(1, longest)), draw(st.integers(1, longest))
    rng = np.random.default_rng(draw(st.integers(0, 2**32)))
    return {name: kind(rng, shape) for name, kind in kinds.items()}


@cache
def machine(backend: str) -> UniversalMachine:
    """One machine a backend, without what other tests have kept; skips where there is no OpenCL."""
    if backend == "opencl":
        pytest.importorskip("pyopencl", reason="the opencl backend needs pyopencl")
        from cnnsim.backends.opencl.device.devices import all_devices

        if not all_devices():
            pytest.skip("there is no OpenCL device")
    return UniversalMachine(backend)


@cache
def program(name: str, **parameters: float) -> Program:
    """A program of the library, read once."""
    return load_program(name, parameters=parameters)


def check(backend: str, name: str, inputs: Planes, answer: Callable[..., dict[str, Any]], **parameters: float) -> None:
    """Run a program and compare every output that the oracle knows, bit for bit."""
    out = machine(backend).run(program(name, **parameters), **inputs)
    agree(out, answer(**inputs, **parameters), inputs)


def check_frames(
    backend: str, name: str, frames: list[Planes], answer: Callable[..., list[dict[str, Any]]], **parameters: float
) -> None:
    """Run a program that keeps planes once a frame, and compare every output of every run."""
    machine(backend).reset()
    for frame, expected in zip(frames, answer(frames, **parameters), strict=True):
        agree(machine(backend).run(program(name, **parameters), **frame), expected, frame)


def agree(out: dict[str, Any], expected: dict[str, Any], inputs: Planes) -> None:
    for name, value in expected.items():
        np.testing.assert_array_equal(
            out[name], value, err_msg=f"{name} of {inputs}", strict=np.asarray(value).dtype == bool
        )
