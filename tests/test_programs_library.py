"""Every program of the library against an answer found another way, on every backend and from 1 x 1 cells up."""

import tomllib
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from scipy import ndimage

from cnnsim import InputError, library
from cnnsim.program_file import load_program
from tests.oracles import programs as oracle
from tests.program_cases import (
    BACKENDS,
    TINY,
    Draw,
    Planes,
    cell,
    check,
    check_frames,
    coarse,
    few,
    gray,
    machine,
    picture,
    planes,
    program,
)

hundred = settings(max_examples=100, deadline=None, suppress_health_check=[HealthCheck.too_slow])

CASES: dict[str, tuple[dict[str, Draw], Callable[..., Any]]] = {
    "opening": ({"picture": picture}, oracle.opening),
    "closing": ({"picture": picture}, oracle.closing),
    "thinning": ({"picture": picture}, oracle.thinning),
    "areas": ({"picture": picture}, oracle.areas),
    "euler-number": ({"picture": picture}, oracle.euler),
    "count-objects": ({"picture": picture}, oracle.objects),
    "count-holes": ({"picture": picture}, oracle.holes),
    "count-runs": ({"picture": picture}, oracle.runs),
    "size-sorting": ({"picture": picture}, oracle.sizes),
    "size-band-contour": ({"picture": picture}, oracle.band),
    "object-isolation": ({"picture": picture, "marker": few}, oracle.isolated),
    "maze-path": ({"walls": picture, "ends": few}, oracle.without_dead_ends),
    "maze-shortest-path": ({"walls": picture, "start": cell, "goal": cell}, oracle.shortest_paths),
    "life": ({"picture": picture}, oracle.life),
    "gray-opening": ({"picture": gray}, oracle.gray_opening),
    "gray-closing": ({"picture": gray}, oracle.gray_closing),
    "gray-gradient": ({"picture": gray}, oracle.gray_gradient),
    "median": ({"picture": gray}, oracle.median),
    "rank-order": ({"picture": coarse}, oracle.ranked),
}
"""Programs with an exact answer: how their inputs are drawn, and the oracle."""

SKELETONS = {"skeleton": oracle.SQUARE, "skeleton-4-connected": oracle.CROSS, "thinning": oracle.SQUARE}
SEQUENCES: dict[str, Callable[..., Any]] = {
    "motion-detection": oracle.motion,
    "motion-speed": oracle.speed,
    "motion-direction": oracle.direction,
}
BY_THEIR_OWN_TESTS = {"halftone-and-back", "texture-segmentation"}
TOUCH = {"contact-blob", "slip-front", "shear-flow", "coherent-shear", "onset-wave"}  # test_touch_programs.py
PIPELINE = {"event-code", "locate-strain", "locate-stress"}  # test_encoding.py, test_inverse.py

FILES = sorted((library.folder() / "programs").glob("*.toml"))


# --- the files --------------------------------------------------------------------------------------------------------


def test_every_program_has_an_oracle() -> None:
    tested = {*CASES, *SKELETONS, *SEQUENCES, *BY_THEIR_OWN_TESTS, *TOUCH, *PIPELINE}
    assert {path.stem for path in FILES} == tested


@pytest.mark.parametrize("path", FILES, ids=[path.stem for path in FILES])
def test_a_file_says_what_a_user_needs(path: Path) -> None:
    text = path.read_text(encoding="utf-8")
    data = tomllib.loads(text)
    assert data["name"] == path.stem
    assert data["summary"].endswith(".")
    assert data["reference"]
    if path.stem not in PIPELINE | {"opening"}:
        comment = text.partition("\nname ")[0]
        assert all(line.startswith("# ") for line in comment.splitlines())
        assert "Limit" in comment or "for every picture" in comment  # what it cannot do


# --- exact answers ----------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("backend", BACKENDS)
@pytest.mark.parametrize("name", CASES)
@hundred
@given(data=st.data())
def test_program(backend: str, name: str, data: st.DataObject) -> None:
    kinds, answer = CASES[name]
    check(backend, name, data.draw(planes(kinds)), answer)


@pytest.mark.parametrize("backend", BACKENDS)
@pytest.mark.parametrize("name", CASES)
def test_program_on_the_smallest_grids(backend: str, name: str) -> None:
    kinds, answer = CASES[name]
    for shape in TINY:
        for seed in range(5):
            rng = np.random.default_rng(seed)
            check(backend, name, {key: kind(rng, shape) for key, kind in kinds.items()}, answer)


@pytest.mark.parametrize(("name", "parameters"), [
    ("life", {"generations": 4}),
    ("size-sorting", {"medium": 1, "large": 3}),
    ("size-band-contour", {"at_least": 2, "too_large": 3}),
    ("gray-opening", {"radius": 2}),
    ("gray-closing", {"radius": 3}),
    *(("rank-order", {"rank": rank}) for rank in (1, 2, 3, 4, 6, 7, 8, 9)),
])  # fmt: skip
@settings(max_examples=20, deadline=None)
@given(data=st.data())
def test_program_with_other_parameters(name: str, parameters: dict[str, float], data: st.DataObject) -> None:
    kinds, answer = CASES[name]
    check("cpu", name, data.draw(planes(kinds, longest=16)), answer, **parameters)


# --- skeletons --------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("backend", BACKENDS)
@pytest.mark.parametrize("name", SKELETONS)
@hundred
@given(inputs=planes({"picture": picture}))
def test_skeleton(backend: str, name: str, inputs: Planes) -> None:
    """A part of the picture with as many objects and holes; peeled again it stays as it is."""
    neighbours = SKELETONS[name]
    background = oracle.CROSS if neighbours is oracle.SQUARE else oracle.SQUARE
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


# --- mazes without loops ----------------------------------------------------------------------------------------------


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
@settings(max_examples=30, deadline=None)
@given(maze=mazes())
def test_dead_ends_and_waves_find_the_same_path(backend: str, maze: Planes) -> None:
    by_wave = machine(backend).run(program("maze-shortest-path"), **maze)
    ends = maze["start"] | maze["goal"]
    by_filling = machine(backend).run(program("maze-path"), walls=maze["walls"], ends=ends)
    assert np.array_equal(by_filling["path"], by_wave["path"])
    assert by_wave["length"] == by_wave["path"].sum() - 1
    assert by_wave["length"] == oracle.distances(~maze["walls"], maze["start"])[maze["goal"]].item()


# --- sequences --------------------------------------------------------------------------------------------------------


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
@settings(max_examples=35, deadline=None, suppress_health_check=[HealthCheck.too_slow])
@given(data=st.data())
def test_sequence(backend: str, name: str, data: st.DataObject) -> None:
    """35 films of four frames."""
    check_frames(backend, name, data.draw(films()), SEQUENCES[name])


@pytest.mark.parametrize("backend", BACKENDS)
@pytest.mark.parametrize("shape", TINY)
@settings(max_examples=4, deadline=None)
@given(data=st.data())
def test_sequence_on_the_smallest_grids(backend: str, shape: tuple[int, int], data: st.DataObject) -> None:
    for name, answer in SEQUENCES.items():
        check_frames(backend, name, data.draw(films(shape)), answer)


@settings(max_examples=35, deadline=None)
@given(frames=films())
def test_speed_up_to_two_cells_a_frame(frames: list[Planes]) -> None:
    check_frames("cpu", "motion-speed", frames, oracle.speed, cells=2)


# --- halftone and texture ---------------------------------------------------------------------------------------------


@pytest.mark.parametrize("backend", BACKENDS)
def test_halftone_and_back(backend: str) -> None:
    """The dots are at rest, so no black (white) cell has a local surplus (deficit) of more than 0.172.

    With B = 5 times the low-pass, a = 1.05 and b = 0.81, a black cell rests where 1.05 + B * (u - y) + b (1 - u + u)
    is at least 1: B * (u - y) >= -0.86 there, and <= 0.86 in white cells. Pictures without symmetry, as in a symmetric
    one two cells may wait for each other for ever.
    """
    weights = np.array(library.load("halftone-5x5").template.B)
    low_pass = np.array(library.load("inverse-halftone-5x5").template.B)
    for seed in range(100):
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
@hundred
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


# --- the language -----------------------------------------------------------------------------------------------------

COUNTING = """
name = "counting"
lam = ["level"]
llm = ["picture", "state"]
wire = ["black", "twice", "rounds", "few"]
inputs = ["picture"]
outputs = ["level", "state", "black", "twice", "rounds", "few"]
parameters = { times = 3, many = 5 }
step = [
  { wire = "count", of = "picture", to = "black" },
  { number = "multiply", of = ["black", 2], to = "twice" },
  { number = "less", of = ["black", "many"], to = "few" },
  { fill = "twice", to = "level" },
  { fill = 0, to = "rounds" },
  { repeat = "times", do = [ { number = "add", of = ["rounds", 1], to = "rounds" } ] },
  { template = "connected-components-horizontal", state = "picture", to = "state" },
]
"""


def _load(tmp_path: Path, text: str, **parameters: float) -> Any:
    file = tmp_path / "p.toml"
    file.write_text(text, encoding="utf-8")
    return load_program(file, parameters=parameters)


@pytest.mark.parametrize("backend", BACKENDS)
def test_numbers_of_wires(backend: str, tmp_path: Path) -> None:
    """Arithmetic on registers, a plane filled from one, rounds from a parameter; a state plane called picture."""
    plane = np.array([[1, 1, 0, 1]], dtype=bool)
    out = machine(backend).run(_load(tmp_path, COUNTING, times=7), picture=plane)
    assert (out["black"], out["twice"], out["rounds"], out["few"]) == (3, 6, 7, 1)
    assert out["level"].tolist() == [[6, 6, 6, 6]]
    assert out["state"].tolist() == [[False, True, False, True]]
    assert machine(backend).run(_load(tmp_path, COUNTING, many=3), picture=plane)["few"] == 0


@pytest.mark.parametrize(("old", "new", "message"), [
    ('number = "add"', 'number = "divide"', "number function 'divide'; known are add, subtract, multiply, less"),
    ('["rounds", 1]', '["rounds"]', "of 1 numbers; two wanted"),
    ('["rounds", 1]', '["rounds", 1.5]', "1.5; a whole number wanted"),
    ('["rounds", 1]', '["rounds", "picture"]', "'picture' is in llm; wire wanted"),
    ('{ fill = 0, to = "rounds" },', "", "'rounds' is read before anything has been written"),
    ('fill = "twice"', 'fill = "rounds"', "'rounds' is read before anything has been written"),
    ('{ fill = 0,', "{ fill = 0.5,", "0.5; a whole number wanted"),
    ('repeat = "times"', 'repeat = "time"', "no parameter 'time'; defined are times, many"),
    ("times = 3", "times = 2.5", "times 2.5; a whole number from 1 wanted"),
    ("times = 3", "times = 0", "times 0.0; a whole number from 1 wanted"),
])  # fmt: skip
def test_wrong_numbers_are_refused(old: str, new: str, message: str, tmp_path: Path) -> None:
    assert old in COUNTING
    with pytest.raises(InputError, match=message):
        _load(tmp_path, COUNTING.replace(old, new))
