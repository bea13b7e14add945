"""What is recorded are the states that the run itself goes through, bit for bit, on every backend."""

from typing import Any

import numpy as np
import pytest

from cnnsim import Frames, Result, Template, Term, library, run, run_transient
from cnnsim.backends.base import Backend
from cnnsim.network import Cell, Characteristic

PICTURE = np.where(np.random.default_rng(3).random((21, 34)) > 0.5, 1.0, -1.0)
CELLS = [(0, 0), (7, 30), (20, 33)]


def both(backend: Backend, name: str, record: Any, **changes: Any) -> tuple[Result, Result]:
    return run(name, PICTURE, backend=backend, **changes), run(name, PICTURE, backend=backend, record=record, **changes)


@pytest.mark.parametrize(
    ("name", "changes"),
    [
        ("hole-filler", {}),
        ("hole-filler", {"scheme": "rk4"}),
        ("hole-filler", {"cell": "full-range"}),
        ("diffusion", {"duration": 3.05}),
        ("median", {"duration": 2.0}),
    ],
)
def test_the_run_ends_as_without_and_its_states_are_recorded(
    backend: Backend, name: str, changes: dict[str, Any]
) -> None:
    plain, times = both(backend, name, np.linspace(0, 2, 9), **changes)
    assert np.array_equal(plain.x, times.x)
    assert (plain.t, plain.settled) == (times.t, times.settled)
    found = times.trajectory
    assert found is not None
    assert np.array_equal(found.x[0], run(name, PICTURE, backend=backend, **{**changes, "duration": 0.0}).x)
    step = plain.plan.step
    for number in (1, 4, 8):
        given = {**changes, "duration": float(found.t[number]), "step": step}
        assert np.array_equal(found.x[number], run(name, PICTURE, backend=backend, **given).x), number
    _, cells = both(backend, name, CELLS, **changes)
    path = cells.trajectory
    assert path is not None
    assert len(path) == round(plain.t / step) + 1
    for number, (row, col) in enumerate(CELLS):
        assert path.x[-1, number] == plain.x[row, col]
        assert np.array_equal(path.x[np.rint(found.t / step).astype(int), number], found.x[:, row, col])


def test_sequences_delays_layers_and_batches(backend: Backend) -> None:
    late = Template([[0.5]], [[1]], 0, "late", [Term([[0, 0.2, 0], [0.2, 0, 0.2], [0, 0.2, 0]], delay=0.5)])
    frames = Frames([PICTURE, -PICTURE, PICTURE], 0.7)
    given: dict[str, Any] = {"state": 0 * PICTURE, "input": frames, "duration": 3.0, "backend": backend}
    plain = run_transient(late, **given)
    kept = run_transient(late, **given, record=[0.0, 0.75, 1.5, 3.0])
    assert kept.trajectory is not None
    assert np.array_equal(kept.trajectory.x[-1], plain.x)
    half = run_transient(late, **{**given, "duration": float(kept.trajectory.t[2])}, step=plain.plan.step)
    assert np.array_equal(kept.trajectory.x[2], half.x)
    wave = library.load("autowave")
    two = run(wave, PICTURE, backend=backend, duration=1.0, record=CELLS)
    assert two.trajectory is not None
    assert np.array_equal(two.trajectory.x[-1], two.x[:, [0, 7, 20], [0, 30, 33]])
    many = run("hole-filler", np.stack([PICTURE, -PICTURE]), backend=backend, record=[1.0])
    assert many.trajectory is not None
    assert many.trajectory.x.shape == (1, 2, 21, 34)


def test_closed_forms_meet_every_time(backend: Backend) -> None:
    kept = run("edge", PICTURE, backend=backend, record=[0.0, 0.123, 2.0])
    assert kept.trajectory is not None
    assert kept.trajectory.t.tolist() == [0.0, 0.123, 2.0]
    assert np.array_equal(kept.trajectory.x[1], run("edge", PICTURE, backend=backend, duration=0.123).x)
    cells = run("edge", PICTURE, backend=backend, record=CELLS)
    assert cells.trajectory is not None
    assert np.abs(cells.trajectory.y[-1] - cells.y[[0, 7, 20], [0, 30, 33]]).max() <= 1e-3


@pytest.mark.parametrize("slope", [0.5, 1.0, 3.0])
@pytest.mark.parametrize("kind", ["clip", "tanh"])
def test_discrete_time_is_recorded_as_it_runs(backend: Backend, kind: Any, slope: float) -> None:
    """The next step starts from the output itself: the characteristic is not applied to it a second time."""
    f, rule = Characteristic(kind, slope), np.array([[0.1, -0.3, 0.2], [0.4, 0.5, -0.2], [0, 0.3, 0.1]])
    start = np.random.default_rng(5).uniform(-1, 1, (9, 12))
    kept = run_transient(
        Template(rule), state=start, cell=Cell("discrete-time", f), duration=4.0, backend=backend, record=[1, 2, 3, 4]
    )
    y, outputs = f(start), list[Any]()
    for _ in range(4):
        around = np.pad(y, 1, mode="edge")
        y = f(sum(rule[k, l] * around[k : k + 9, l : l + 12] for k, l in np.ndindex(3, 3)))
        outputs.append(y)
    assert kept.trajectory is not None
    assert np.abs(kept.trajectory.x - outputs).max() < 1e-5
    assert np.array_equal(kept.trajectory.x[-1], kept.x)
