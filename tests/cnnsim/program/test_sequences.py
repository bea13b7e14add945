"""Programs that go over moving pictures."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tests.kits.program_cases import BACKENDS, TINY, Planes, check_frames
from tests.oracles import sequences
from tests.oracles.sequences import SEQUENCES


@st.composite
def films(draw: st.DrawFn, shape: tuple[int, int] | None = None) -> list[Planes]:
    """Rectangles that walk by at most two cells a frame, some of them at rest, and sometimes a wrong pixel."""
    shape = shape or (draw(st.integers(1, 14)), draw(st.integers(1, 14)))
    rng = np.random.default_rng(draw(st.integers(0, 2**32)))
    things = [
        (rng.integers(0, shape), rng.integers(1, 5, 2), rng.integers(-2, 3, 2) * rng.integers(0, 2))
        for _ in range(rng.integers(0, 5))
    ]
    frames = []
    for t in range(4):
        frame = np.zeros(shape, dtype=bool)
        for place, size, speed in things:
            (top, left), (bottom, right) = (np.maximum(corner + t * speed, 0) for corner in (place, place + size))
            frame[top:bottom, left:right] = True
        frames.append({"frame": frame ^ (rng.random(shape) < rng.choice([0, 0, 0.03]))})
    return frames


@pytest.mark.parametrize("backend", BACKENDS)
@pytest.mark.parametrize("name", SEQUENCES)
@settings(max_examples=15)
@given(data=st.data())
def test_sequence(backend: str, name: str, data: st.DataObject) -> None:
    """Films of four frames."""
    check_frames(backend, name, data.draw(films()), SEQUENCES[name])


@pytest.mark.parametrize("backend", BACKENDS)
@pytest.mark.parametrize("shape", TINY)
@settings(max_examples=2)
@given(data=st.data())
def test_sequence_on_the_smallest_grids(backend: str, shape: tuple[int, int], data: st.DataObject) -> None:
    for name, answer in SEQUENCES.items():
        check_frames(backend, name, data.draw(films(shape)), answer)


@settings(max_examples=35)
@given(frames=films())
def test_speed_up_to_two_cells_a_frame(frames: list[Planes]) -> None:
    check_frames("cpu", "motion-speed", frames, sequences.speed, cells=2)
