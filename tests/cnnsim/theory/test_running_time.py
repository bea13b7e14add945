"""Guaranteed running times of cells without neighbours, and what theory says of the others."""

from typing import Any

import numpy as np
import pytest

from cnnsim import ZERO_FLUX, Template, fixed, library
from cnnsim.network.cell import output, uncoupled_state
from cnnsim.theory import running_time
from cnnsim.theory.running_time import TOLERANCE, cell_time, guaranteed_time, time_of_picture
from cnnsim.transient import run_transient
from tests.kits.time import final, guaranteed, pictures

EXACT: dict[str, Any] = {"scheme": "rk4", "step": 0.05, "dtype": "float64"}

EULER: dict[str, Any] = {"scheme": "euler", "step": 0.1, "dtype": "float64"}

UNCOUPLED = [
    name
    for name in library.names("uncoupled")
    if "binary" in library.load(name).tags and library.load(name).template.radius <= 1
]


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
    found = entry.running_time((9, 9))
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
        assert np.abs(run_transient(template, **{**task, **scheme}, duration=time).y - rest).max() <= TOLERANCE


def test_a_boundary_that_no_proof_covers_has_no_guarantee(monkeypatch: pytest.MonkeyPatch) -> None:
    assert guaranteed_time(library.load("shadow-left").template, (8, 9), ZERO_FLUX).time is not None
    monkeypatch.setattr(running_time, "PROVED", ("fixed",))
    assert "no bound is known for a zero-flux boundary" in str(
        guaranteed_time(library.load("shadow-left").template, (8, 9), ZERO_FLUX)
    )
