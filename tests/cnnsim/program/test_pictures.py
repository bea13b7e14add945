"""Programs whose answer is a property: skeletons, mazes without loops, halftones, textures."""

from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy import ndimage

from cnnsim import library
from tests.kits.program_cases import BACKENDS, TINY, Planes, gray, machine, picture, planes, program
from tests.oracles import programs as oracle
from tests.oracles.mazes import distances
from tests.oracles.pictures import CROSS, SQUARE
from tests.oracles.programs import SKELETONS


@pytest.mark.parametrize("backend", BACKENDS)
@pytest.mark.parametrize("name", SKELETONS)
@settings(max_examples=20)
@given(inputs=planes({"picture": picture}))
def test_skeleton(backend: str, name: str, inputs: Planes) -> None:
    """A part of the picture with as many objects and holes; peeled again it stays as it is."""
    neighbours = SKELETONS[name]
    background = CROSS if neighbours is SQUARE else SQUARE
    before = inputs["picture"]
    after = _skeleton(backend, name, before)
    assert not (after & ~before).any()
    assert oracle.count(after, neighbours) == oracle.count(before, neighbours)
    assert oracle.hole_count(after, background) == oracle.hole_count(before, background)
    assert np.array_equal(_skeleton(backend, name, after), after)


def _skeleton(backend: str, name: str, before: Any) -> Any:
    (after,) = machine(backend).run(program(name), picture=before).values()
    return after


@pytest.mark.parametrize("name", SKELETONS)
@pytest.mark.parametrize("shape", [*TINY, (3, 3), (4, 11), (12, 5), (20, 20)])
def test_skeleton_of_lines_and_blocks(name: str, shape: tuple[int, int]) -> None:
    """A line one cell wide is its own skeleton; a full block leaves lines, without a 3 x 3 square in them."""
    block = np.ones(shape, dtype=bool)
    after = _skeleton("reference", name, block)
    assert after.any()
    if 1 in shape:
        assert np.array_equal(after, block)
    assert not oracle.eroded(after, 1).any()


@st.composite
def mazes(draw: st.DrawFn) -> Planes:
    """A maze in which one path joins any two rooms: depth-first carving. Start and goal are two of its rooms."""
    rows, cols = draw(st.integers(1, 6)), draw(st.integers(1, 6))
    rng = np.random.default_rng(draw(st.integers(0, 2**32)))
    walls = np.ones((2 * rows + 1, 2 * cols + 1), dtype=bool)
    walls[1, 1] = False
    stack = [(1, 1)]
    while stack:
        i, j = stack[-1]
        ways = [(k, l) for k, l in ((0, 2), (0, -2), (2, 0), (-2, 0)) if _is_wall(walls, i + k, j + l)]
        if not ways:
            stack.pop()
            continue
        k, l = ways[rng.integers(len(ways))]
        walls[i + k // 2, j + l // 2] = walls[i + k, j + l] = False
        stack.append((i + k, j + l))
    start, goal = np.zeros_like(walls), np.zeros_like(walls)
    for plane in (start, goal):
        plane[2 * rng.integers(rows) + 1, 2 * rng.integers(cols) + 1] = True
    return {"walls": walls, "start": start, "goal": goal}


def _is_wall(walls: Any, i: int, j: int) -> bool:
    return 0 < i < walls.shape[0] and 0 < j < walls.shape[1] and bool(walls[i, j])


@pytest.mark.parametrize("backend", BACKENDS)
@settings(max_examples=30)
@given(maze=mazes())
def test_dead_ends_and_waves_find_the_same_path(backend: str, maze: Planes) -> None:
    by_wave = machine(backend).run(program("maze-shortest-path"), **maze)
    ends = maze["start"] | maze["goal"]
    by_filling = machine(backend).run(program("maze-path"), walls=maze["walls"], ends=ends)
    assert np.array_equal(by_filling["path"], by_wave["path"])
    assert by_wave["length"] == by_wave["path"].sum() - 1
    assert by_wave["length"] == distances(~maze["walls"], maze["start"])[maze["goal"]].item()


@pytest.mark.parametrize("backend", BACKENDS)
def test_halftone_and_back(backend: str) -> None:
    """The dots are at rest, so no black (white) cell has a local surplus (deficit) of more than 0.172.

    With B = 5 times the low-pass, a = 1.05 and b = 0.81, a black cell rests where 1.05 + B * (u - y) + b (1 - u + u)
    is at least 1: B * (u - y) >= -0.86 there, and <= 0.86 in white cells. Pictures without symmetry, as in a symmetric
    one two cells may wait for each other for ever.
    """
    weights = np.array(library.load("halftone-5x5").template.B)
    low_pass = np.array(library.load("inverse-halftone-5x5").template.B)
    for seed in range(40):
        rng = np.random.default_rng(seed)
        shape = rng.integers(1, 13, 2)
        noise = rng.uniform(-1, 1, shape)
        gray = np.clip(ndimage.gaussian_filter(4 * noise, 2), -1, 1) if seed % 2 else noise
        out = machine(backend).run(program("halftone-and-back"), picture=gray)
        dots = np.where(out["dots"], 1.0, -1.0)
        error = ndimage.correlate(gray - dots, weights, mode="constant")
        assert (error * dots).min() >= -0.86 - 1e-3
        assert out["restored"] == pytest.approx(ndimage.correlate(dots, low_pass, mode="nearest"), abs=1e-6)
        if min(shape) > 6:
            assert dots.mean() == pytest.approx(gray.mean(), abs=0.1)


@pytest.mark.parametrize("backend", BACKENDS)
@pytest.mark.parametrize("averages", [1, 3])
@settings(max_examples=30)
@given(inputs=planes({"picture": gray}))
def test_texture_segmentation(backend: str, averages: int, inputs: Planes) -> None:
    """Edge density to rounding; rough where it is above the level, wherever rounding cannot decide."""
    out = machine(backend).run(program("texture-segmentation", averages=averages), **inputs)
    density = oracle.edge_density(inputs["picture"], averages)
    assert out["density"] == pytest.approx(density, abs=1e-6)
    clear = np.abs(density - 0.2) > 1e-6
    assert np.array_equal(out["rough"][clear], density[clear] > 0.2)


def test_texture_segmentation_tells_a_checkerboard_from_a_plain() -> None:
    checkerboard = np.where(np.indices((12, 24)).sum(axis=0) % 2, 1.0, -1.0)
    checkerboard[:, 12:] = 0.3
    rough = machine("cpu").run(program("texture-segmentation"), picture=checkerboard)["rough"]
    assert rough[:, :11].all()
    assert not rough[:, 16:].any()
