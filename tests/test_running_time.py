"""Guaranteed running times: enough on random pictures and in mazes, and not wildly too much."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from cnnsim import PERIODIC, ZERO_FLUX, Template, fixed, library
from cnnsim.cell import output, uncoupled_state
from cnnsim.machine import UniversalMachine
from cnnsim.plan import usual_limit
from cnnsim.program_file import load_program
from cnnsim.running_time import TOLERANCE, cell_time, guaranteed_time, time_of_entry, time_of_picture
from cnnsim.transient import NotSettledError, run_transient
from tests.oracles.pictures import plane

EXACT: dict[str, Any] = {"scheme": "rk4", "step": 0.05, "backend": "reference"}
EULER: dict[str, Any] = {"scheme": "euler", "step": 0.1, "backend": "reference"}

UNCOUPLED = [
    name
    for name in library.names("uncoupled")
    if "binary" in library.load(name).tags and library.load(name).template.radius <= 1
]
WAVES = {
    "hole-filler": 2.5, "shadow-left": 2.0, "shadow-down": 2.0, "shadow-vertical": 2.5, "recall": 3.0,
    "patch-maker": 3.0, "trigger-wave": 3.5, "trigger-wave-white": 3.5, "masked-erase": 3.0, "masked-shadow": 3.0,
    "concave-filler": 4.0, "framed-areas": 4.0, "connectivity": 4.5,
}  # fmt: skip
"""Trigger waves, and how many times longer than needed their guaranteed time may be on random pictures."""


def guaranteed(name: str, shape: tuple[int, int], **more: Any) -> float:
    entry = library.load(name)
    found = time_of_entry(entry, shape, **more)
    assert found.time is not None, found
    return found.time


def pictures(name: str, shape: tuple[int, int]) -> list[dict[str, Any]]:
    """Planes of random pictures as the template wants them, a sparse and a dense one."""
    rng = np.random.default_rng([*name.encode(), *shape])
    entry, tasks = library.load(name), []
    for share in (0.3, 0.6):
        first = rng.random(shape) < share
        second = {
            "recall": first & (rng.random(shape) < 0.1),
            "connectivity": first & (rng.random(shape) < 0.9),
            "masked-shadow": ~first & (rng.random(shape) < 0.3),
        }.get(name, rng.random(shape) < 0.5)
        given = plane(second) if entry.initial_state == "given" else None
        planes = entry.planes(plane(first), given)
        if entry.initial_state == "any":
            planes["state"] = plane(second)
        tasks.append({**planes, "boundary": entry.boundary})
    return tasks


def final(name: str, task: dict[str, Any]) -> NDArray[Any]:
    return run_transient(library.load(name).template, **task, limit=20_000.0).y


# --- cells without neighbours -----------------------------------------------------------------------------------


@pytest.mark.parametrize("a", [-1.0, 0.0, 0.5, 1.0, 1.5, 3.0])
def test_a_cell_is_final_at_its_time_and_not_before(a: float) -> None:
    rng = np.random.default_rng(3)
    s, x0 = rng.uniform(-3, 3, 400), rng.uniform(-1, 1, 400)
    times = cell_time(s, x0, a, 1e-9)
    for cell in range(400):

        def y(t: float, cell: int = cell) -> float:
            return float(output(uncoupled_state(x0[cell : cell + 1], s[cell : cell + 1], a, t, "chua-yang"))[0])

        tolerance = TOLERANCE * 1.001 if a < 1 else 1e-6
        assert abs(y(times[cell] + 1e-6) - y(np.inf)) <= tolerance
        if times[cell] > 0.01:
            assert abs(y(times[cell] * 0.99) - y(np.inf)) > (TOLERANCE if a < 1 else 0)


@pytest.mark.parametrize("name", UNCOUPLED)
def test_uncoupled_templates_are_done_in_time_and_their_worst_neighbourhood_needs_it(name: str) -> None:
    """Among random pictures of 40 x 40 cells some cell needs more than half the time that is given."""
    entry = library.load(name)
    time = guaranteed(name, (40, 40), step=0.1)
    barely = guaranteed(name, (40, 40), step=1e-6)
    assert barely <= time <= 1.2 * barely + 0.2
    slow = False
    for task in pictures(name, (40, 40)):
        y = final(name, task)
        schemes: tuple[dict[str, Any], ...] = ({}, EULER, EXACT)
        for scheme in schemes:
            wait = (time if scheme is EULER else barely + 0.02) + 1e-9
            end = run_transient(entry.template, **task, **scheme, duration=wait).y
            assert np.abs(end - y).max() <= (TOLERANCE * 1.01 if entry.template.self_feedback < 1 else 1e-3)
        early = run_transient(entry.template, **task, duration=0.5 * barely, dtype="float64").y
        slow |= bool(np.abs(early - y).max() > TOLERANCE)
    assert slow or barely == 0


def test_one_picture_has_the_time_of_its_slowest_cell() -> None:
    """EDGE: the slowest cells have |s| = 1 and need one time constant from x(0) = 0; all white ones have s = -9."""
    entry = library.load("edge")
    square = np.pad(np.ones((4, 4)), 3, constant_values=-1.0)
    white, start = np.full((5, 5), -1.0), np.zeros((5, 5))
    found = time_of_picture(entry.template, state=np.zeros((10, 10)), input=square, boundary=fixed(-1), step=1e-6)
    assert found.time == pytest.approx(1.0, abs=1e-5)
    found = time_of_picture(entry.template, state=start, input=white, boundary=fixed(-1), step=1e-6)
    assert found.time == pytest.approx(1.0, abs=1e-5)  # -8 + 8 - 1
    found = time_of_picture(entry.template, state=start, input=-white, boundary=fixed(1), step=1e-6)
    assert found.time == pytest.approx(1.0, abs=1e-5)
    corners = time_of_picture(entry.template, state=start, input=-white, boundary=fixed(-1), step=1e-6)
    assert corners.time == pytest.approx(1.0, abs=1e-5)


# --- waves ------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("shape", [(1, 1), (1, 7), (6, 1), (2, 2), (9, 13), (24, 24)])
@pytest.mark.parametrize("name", WAVES)
def test_waves_are_done_in_time(name: str, shape: tuple[int, int]) -> None:
    entry = library.load(name)
    worst = guaranteed(name, shape)
    for task in pictures(name, shape):
        own = time_of_picture(entry.template, **task)
        assert own.time is not None
        assert own.time <= worst + 1e-9
        y = final(name, task)
        for scheme in (EULER, EXACT):
            end = run_transient(entry.template, **task, **scheme, duration=own.time).y
            assert np.array_equal(end, np.sign(y)), f"{np.abs(end - y).max()} off at {own.time}"


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


def test_a_mask_makes_walls() -> None:
    entry, corridor = library.load("trigger-wave"), serpentine(9, 10)
    start = np.full((9, 10), -1.0)
    start[0, 0] = 1.0
    task: dict[str, Any] = {"state": start, "mask": plane(~corridor), "boundary": ZERO_FLUX}
    own = time_of_picture(entry.template, **task).time
    assert own is not None
    assert guaranteed("trigger-wave", (9, 10)) < own <= guaranteed("trigger-wave", (9, 10), walls=True)
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
    """Templates nobody has chosen: whenever a time is promised, it is kept."""
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
        task: dict[str, Any] = {"state": x, "input": u, "boundary": boundary, "backend": "reference"}
        end = run_transient(template, **task, duration=own.time).y
        assert np.abs(end).min() >= 1 - 1e-9
        assert np.array_equal(end, run_transient(template, **task, duration=own.time + 40).y)
    assert promised >= 10


@pytest.mark.parametrize(
    ("name", "reason"),
    [
        ("connected-components-horizontal", "negative"),
        ("figure-reconstructor", "tie"),
        ("small-object-remover", "both colours"),
        ("diffusion", "a <= 1"),
        ("autowave", "layers"),
        ("median", "non-linear"),
        ("discrete-hole-filler", "Chua and Yang"),
    ],
)
def test_where_theory_gives_no_time_the_reason_is_told(name: str, reason: str) -> None:
    entry = library.load(name)
    found = time_of_entry(entry, (9, 9))
    assert found.time is None
    assert reason in str(found)


def test_a_contraction_is_known_by_its_norm() -> None:
    template = Template([[0, 0.2, 0], [0.2, 0, 0.2], [0, -0.2, 0]], 1.0, 0.5)
    rng = np.random.default_rng(1)
    u, x = rng.uniform(-1, 1, (2, 9, 9))
    time = guaranteed_time(template, (9, 9), ZERO_FLUX).time
    assert time is not None
    task: dict[str, Any] = {"state": x, "input": u, "dtype": "float64"}
    rest = run_transient(template, **task, duration=200.0).y
    schemes: tuple[dict[str, Any], ...] = ({}, EULER)
    for scheme in schemes:
        assert np.abs(run_transient(template, **task, **scheme, duration=time).y - rest).max() <= TOLERANCE
