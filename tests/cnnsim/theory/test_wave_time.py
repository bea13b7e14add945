"""Guaranteed running times of waves: enough on random pictures and in mazes, and not wildly too much."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from cnnsim import PERIODIC, ZERO_FLUX, Template, fixed, library
from cnnsim.convergence import NotSettledError
from cnnsim.planning.plan import usual_limit
from cnnsim.program.file import load_program
from cnnsim.program.machine import UniversalMachine
from cnnsim.theory.running_time import guaranteed_time, time_of_picture
from cnnsim.transient import run_transient
from tests.kits.time import final, guaranteed, pictures
from tests.oracles.pictures import plane

EXACT: dict[str, Any] = {"scheme": "rk4", "step": 0.05, "dtype": "float64"}

EULER: dict[str, Any] = {"scheme": "euler", "step": 0.1, "dtype": "float64"}

WAVES = {
    "hole-filler": 2.5, "shadow-left": 2.0, "shadow-down": 2.0, "shadow-vertical": 2.5, "recall": 3.0,
    "patch-maker": 3.0, "trigger-wave": 3.5, "trigger-wave-white": 3.5, "masked-erase": 3.0, "masked-shadow": 3.0,
    "concave-filler": 4.0, "framed-areas": 4.0, "connectivity": 4.5,
}  # fmt: skip
"""Trigger waves, and how many times longer than needed their guaranteed time may be on random pictures."""


@pytest.mark.parametrize("name", WAVES)
def test_waves_are_done_in_time(name: str) -> None:
    entry = library.load(name)
    for shape in [(1, 1), (1, 7), (6, 1), (2, 2), (9, 13), (24, 24)]:
        for task in pictures(name, shape):
            own = time_of_picture(entry.template, **task)
            assert own.time is not None
            assert own.time <= guaranteed(name, shape) + 1e-9
            y = final(name, task)
            for scheme in (EULER, EXACT):
                end = run_transient(entry.template, **task, **scheme, duration=own.time).y
                assert np.array_equal(end, np.sign(y)), f"{shape}: {np.abs(end - y).max()} off at {own.time}"


@pytest.mark.parametrize(("name", "factor"), WAVES.items())
def test_waves_are_not_told_to_wait_much_too_long(name: str, factor: float) -> None:
    entry = library.load(name)
    for task in pictures(name, (24, 24)):
        own = time_of_picture(entry.template, **task, step=0.02)
        assert own.time is not None
        y = np.sign(final(name, task))
        early = run_transient(entry.template, **task, **EXACT, duration=own.time / factor).y
        assert not np.array_equal(early, y) or own.time < 2, own


def serpentine(rows: int, cols: int) -> NDArray[np.bool_]:
    """A corridor one cell wide through the whole grid, with walls one cell thick; True in the corridor."""
    corridor = np.zeros((rows, cols), dtype=bool)
    corridor[0::2] = True
    for number, row in enumerate(range(1, rows, 2)):
        corridor[row, -1 if number % 2 == 0 else 0] = True
    return corridor


@pytest.mark.parametrize("scheme", [EULER, EXACT], ids=["euler", "rk4"])
def test_recall_through_a_serpentine(scheme: dict[str, Any]) -> None:
    """The longest maze of a 15 x 16 grid: the picture's own time holds within 1.5, the grid's within 2.5."""
    entry, corridor = library.load("recall"), serpentine(15, 16)
    marker = np.zeros_like(corridor)
    marker[0, 0] = True
    task: dict[str, Any] = {"state": plane(marker), "input": plane(corridor), "boundary": entry.boundary}
    own, worst = time_of_picture(entry.template, **task).time, guaranteed("recall", (15, 16))
    assert own is not None
    assert own <= worst <= 1.4 * own
    assert np.array_equal(run_transient(entry.template, **task, **scheme, duration=own).y > 0, corridor)
    short = run_transient(entry.template, **task, **scheme, duration=own / 1.8).y
    assert not np.array_equal(short > 0, corridor)


@pytest.mark.parametrize("scheme", [EULER, EXACT], ids=["euler", "rk4"])
def test_hole_filler_through_a_serpentine(scheme: dict[str, Any]) -> None:
    """White has one way in, at the corridor's end; the wave has to go through all of it."""
    entry, corridor = library.load("hole-filler"), serpentine(13, 14)
    drawn = np.ones((15, 16), dtype=bool)
    drawn[1:-1, 1:-1] = ~corridor
    drawn[0, 1] = False
    task: dict[str, Any] = {"state": np.ones((15, 16)), "input": plane(drawn), "boundary": entry.boundary}
    own, worst = time_of_picture(entry.template, **task).time, guaranteed("hole-filler", (15, 16))
    assert own is not None
    assert own <= worst <= 2.5 * own
    assert np.array_equal(run_transient(entry.template, **task, **scheme, duration=own).y > 0, drawn)
    short = run_transient(entry.template, **task, **scheme, duration=own / 1.8).y
    assert not np.array_equal(short > 0, drawn)


def test_a_program_waits_for_the_guaranteed_time(tmp_path: Path) -> None:
    """A maze of 39 x 40 cells takes the wave longer than a plan waits for rest where theory knows no time."""
    entry, corridor = library.load("trigger-wave"), serpentine(39, 40)
    start = np.zeros_like(corridor)
    start[0, 0] = True
    file = tmp_path / "wave.toml"
    file.write_text("""
name = "wave"
inputs = ["start", "walls"]
outputs = ["found"]
llm = ["start", "walls", "found"]
[[step]]
template = "trigger-wave"
state = "start"
mask = "walls"
duration = "settled"
to = "found"
""")
    found = UniversalMachine().run(load_program(file), start=start, walls=~corridor)["found"]
    assert np.array_equal(found > 0, corridor)
    task: dict[str, Any] = {"state": plane(start), "mask": plane(~corridor), "boundary": entry.boundary}
    with pytest.raises(NotSettledError):
        run_transient(entry.template, **task, limit=usual_limit((39, 40)))


def test_masked_cells_stand_in_the_way() -> None:
    entry, corridor = library.load("trigger-wave"), serpentine(9, 10)
    start = np.full((9, 10), -1.0)
    start[0, 0] = 1.0
    task: dict[str, Any] = {"state": start, "mask": plane(~corridor), "boundary": ZERO_FLUX}
    own = time_of_picture(entry.template, **task).time
    assert own is not None
    assert guaranteed("trigger-wave", (9, 10)) < own <= guaranteed("trigger-wave", (9, 10), has_mask=True)
    assert np.array_equal(run_transient(entry.template, **task, duration=own).y > 0, corridor)


@pytest.mark.parametrize(
    ("name", "promised", "measured"),
    [
        ("trigger-wave", 1.1112, 1.66234),
        ("patch-maker", 0.3338, 0.49991),
        ("shadow-vertical", 0.5581, 0.72135),
        ("recall", 1.6943, 2.45110),
        ("shadow-left", 1.2523, 1.73803),
    ],
)
def test_speeds_of_planar_fronts(name: str, promised: float, measured: float) -> None:
    """Cells per time constant: by hand from T_sw (neighbours within the front count as white), and measured."""
    entry, times = library.load(name), []
    for length in (30, 60):
        start = np.full((length, 5), -1.0)
        start[0] = 1.0
        task: dict[str, Any] = {"state": start, "boundary": entry.boundary, "step": 1e-7}
        if name == "shadow-left":
            task.update(state=np.ones((1, length)), input=np.full((1, length), -1.0))
        elif name in ("recall", "patch-maker"):
            task.update(input=start if name == "patch-maker" else np.ones_like(start))
        found = time_of_picture(entry.template, **task)
        assert found.time is not None
        times.append(found.time)
    speed = 30 / (times[1] - times[0])
    assert speed == pytest.approx(promised, abs=1e-4)
    assert 1.0 < measured / speed < 1.51


@pytest.mark.parametrize("boundary", [ZERO_FLUX, PERIODIC, fixed(-1), fixed(0.3)])
def test_random_one_way_templates(boundary: Any) -> None:
    """Random templates: if a time is guaranteed, the transient keeps it."""
    rng, promised = np.random.default_rng(8), 0
    for _ in range(60):
        a = rng.uniform(0, 1.0, (3, 3)) * (rng.random((3, 3)) < 0.6)
        a[1, 1] = rng.uniform(1.2, 4)
        template = Template(a, rng.uniform(0, 3), rng.uniform(-2, 4))
        roles = {"input": "picture", "initial_state": rng.choice(["picture", "given"])}
        found = guaranteed_time(template, (7, 8), boundary, **roles)
        u = np.where(rng.random((7, 8)) < 0.5, 1.0, -1.0)
        x = u if roles["initial_state"] == "picture" else np.where(rng.random((7, 8)) < 0.2, u, -1.0)
        own = time_of_picture(template, state=x, input=u, boundary=boundary)
        if found.time is not None and not found.assuming:
            assert own.time is not None
            assert own.time <= found.time + 1e-9
        if own.time is None or template.uncoupled:
            continue
        promised += 1
        task: dict[str, Any] = {"state": x, "input": u, "boundary": boundary, "dtype": "float64"}
        end = run_transient(template, **task, duration=own.time)
        assert np.abs(end.y).min() >= 1 - 1e-9
        assert np.array_equal(end.y, run_transient(template, **{**task, "state": end.x}, duration=40.0).y)
    assert promised >= 10


def reached(shape: tuple[int, int], offsets: list[tuple[int, int]], kind: str, start: tuple[int, int]) -> Any:
    """The cells that a wave comes to from one cell, looked up one by one: each is set off by any of its offsets."""

    def stands(i: int, n: int) -> int:
        return i % n if kind == "periodic" else min(max(i, 0), n - 1) if kind == "zero-flux" else i

    black, more = {start}, True
    while more:
        cells = [(i, j) for i in range(shape[0]) for j in range(shape[1]) if (i, j) not in black]
        new = {
            c
            for c in cells
            if any((stands(c[0] + k, shape[0]), stands(c[1] + l, shape[1])) in black for k, l in offsets)
        }
        black, more = black | new, bool(new)
    return np.array([[(i, j) in black for j in range(shape[1])] for i in range(shape[0])])


@pytest.mark.parametrize("boundary", [fixed(-1), PERIODIC, ZERO_FLUX], ids=str)
@pytest.mark.parametrize("offset", [(0, 1), (0, 2), (0, 3), (1, 1), (1, -2), (2, 2)], ids=str)
@pytest.mark.parametrize("opposite", [False, True], ids=["one way", "both ways"])
def test_a_wave_along_a_line_is_done_in_time_however_often_it_goes_round(
    opposite: bool, offset: tuple[int, int], boundary: Any
) -> None:
    (k, l), r = offset, max(map(abs, offset))
    offsets, A = [(k, l), *([(-k, -l)] if opposite else [])], np.zeros((2 * r + 1, 2 * r + 1))
    for p, q in offsets:
        A[r + p, r + q] = 1.2
    A[r, r] = 2.0
    template = Template(A, 0.0, 1.6 if opposite else 0.5)
    for shape in ((1, 6), (5, 5), (3, 4), (4, 7), (6, 1)):
        time = guaranteed_time(template, shape, boundary, input="none", initial_state="picture").time
        assert time is not None
        for start in ((0, 0), (shape[0] - 1, shape[1] - 1), (shape[0] // 2, shape[1] // 2)):
            state = np.full(shape, -1.0)
            state[start] = 1.0
            end = run_transient(template, state=state, boundary=boundary, **EULER, duration=time).y
            assert np.array_equal(end, plane(reached(shape, offsets, boundary.kind, start))), (shape, start)
