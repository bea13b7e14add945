"""Memory of a transient: at most five planes of the dtype computed in, as `explain` counts."""

import subprocess
import sys
import tracemalloc
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from PIL import Image

from cnnsim import (
    Frames,
    InputError,
    Template,
    Term,
    explain,
    library,
    run_transient,
    trajectory,
)
from cnnsim.task import make_task
from tests.kits.paths import ROOT

SIZES = (520, 900)  # scratch memory of threads no longer grows with the size


def picture_of(size: int, dtype: str = "float32") -> np.ndarray:
    return np.where(np.random.default_rng(0).random((size, size)) < 0.4, 1.0, -1.0).astype(dtype)


def bytes_per_cell(given: int, do: Callable[[int], Any]) -> float:
    """Return the peak bytes of a run per cell, between two sizes, with the ``given`` bytes of its planes."""
    peaks = []
    do(SIZES[0])()  # compiles: slow where every allocation is traced
    for size in SIZES:
        planes = do(size)
        tracemalloc.start()
        result = planes()
        peaks.append(tracemalloc.get_traced_memory()[1])
        tracemalloc.stop()
        assert result is not None
    return given + (peaks[-1] - peaks[-2]) / (SIZES[1] ** 2 - SIZES[0] ** 2)


def test_float64_computed_in_float64() -> None:
    def prepared(size: int) -> Callable[[], Any]:
        x = picture_of(size, "float64")
        nine = np.full((3, 3), 0.1)
        return lambda: run_transient(Template(nine, nine), state=x, input=x, duration=2.0, dtype="float64")

    assert bytes_per_cell(8, prepared) <= 40.5


def test_a_delay_takes_a_plane_for_each_of_its_steps() -> None:
    template = Template(np.full((3, 3), 0.1), terms=[Term(np.full((3, 3), 0.03), "x_kl", delay=0.3)])

    def choices(size: int) -> dict[str, Any]:
        return {"state": picture_of(size), "duration": 1.0, "step": 0.1}

    def prepared(size: int) -> Callable[[], Any]:
        given = choices(size)
        return lambda: run_transient(template, **given)

    said = make_task(template, **choices(9)).cell_bytes(4)
    assert said == 4 * (1 + 3 + 3)
    assert bytes_per_cell(4, prepared) == pytest.approx(said, rel=0.05)


CASES: dict[str, dict[str, Any]] = {
    "closed form": {"template": "edge"},
    "steps by turns": {"template": "hole-filler", "duration": 2.0},
    "mask": {"template": "hole-filler", "duration": 2.0, "mask": True},
    "four stages": {"template": "hole-filler", "duration": 2.0, "scheme": "rk4", "step": 0.1},
    "full range": {"template": "hole-filler", "duration": 2.0, "cell": "full-range"},
    "terms": {"template": "median", "duration": 0.1},
    "terms with a mask": {"template": "median", "duration": 0.1, "mask": True},
    "terms by stages": {"template": "median", "duration": 0.1, "scheme": "rk4"},
    "discrete time": {"template": "discrete-hole-filler", "duration": 3.0},
    "terms of the input": {"template": "local-maxima", "duration": 0.5},
    "layers": {"template": "autowave", "duration": 0.1},
    "bias": {"template": "diffusion", "duration": 2.0, "bias": True},
}


@pytest.mark.parametrize("case", CASES)
def test_a_run_takes_the_bytes_that_explain_counts(case: str) -> None:
    choices = dict(CASES[case])
    entry = library.load(choices.pop("template"))
    maps = [key for key in ("mask", "bias") if choices.pop(key, False)]

    def task_of(size: int) -> dict[str, Any]:
        task = {**entry.task(picture_of(size)), **choices}
        return task | {key: np.zeros((size, size), "float32") for key in maps}

    def prepared(size: int) -> Callable[[], Any]:
        task = task_of(size)
        return lambda: run_transient(entry.network, **task)

    task = make_task(entry.network, **task_of(10))
    layers = task.state.size / 100
    constant = 0.0 in task.state.strides
    given = 4 * (len(task.planes) - constant) + (4 if "mask" in maps else 0)
    said = task.cell_bytes(4) * layers + (4 if "mask" in maps else 0)
    found = bytes_per_cell(given, prepared)
    assert found == pytest.approx(said, rel=0.12)
    assert found <= 5.25 * 4 * layers + (
        6.2 if maps else 0
    )  # a given map: 4 bytes; a mask: 2.1 as bits and truth values


PEAK = """
import resource, sys
from cnnsim.cli.group import main
main(sys.argv[1:], standalone_mode=False)
print(resource.getrusage(resource.RUSAGE_SELF).ru_maxrss, file=sys.stderr)
"""


@pytest.mark.parametrize("choices", [(), ("--scheme", "rk4")], ids=["euler", "rk4"])
def test_the_command_line(choices: tuple[str, ...], tmp_path: Path) -> None:
    """Peak memory of whole processes, of which one compiles: the picture is read, run and written."""
    peaks = []
    for size in (100, 600, 1800):
        Image.fromarray(np.where(picture_of(size) > 0, 0, 255).astype(np.uint8)).save(tmp_path / "x.png")
        words = [
            "run",
            "hole-filler",
            tmp_path / "x.png",
            "--time",
            "1",
            *choices,
            "-o",
            tmp_path / "y.png",
            "--replace",
        ]
        done = subprocess.run(
            [sys.executable, "-c", PEAK, *map(str, words)], cwd=ROOT, capture_output=True, text=True, check=True
        )
        peaks.append(1024 * int(done.stderr.splitlines()[-1]))
    assert (peaks[2] - peaks[1]) / (1800**2 - 600**2) <= 20.5


def test_explain_counts_the_memory_of_the_backend_that_is_asked_for() -> None:
    """Terms that read the input of two times: copies on both; OpenCL has two planes of states and two of outputs."""
    delayed = Template(0.5, terms=[Term(0.1, "u_kl"), Term(0.2, "u_kl", delay=0.2)])
    found = {name: explain(delayed, (90, 90), name, duration=1.0, step=0.1) for name in ("cpu", "opencl")}
    assert {name: facts.cell_bytes for name, facts in found.items()} == {"cpu": 4 * 8, "opencl": 4 * 9}
    assert all(f"on {name}," in str(facts) for name, facts in found.items())
    with pytest.raises(InputError, match="'reference': its memory is not counted; one of cpu, opencl wanted"):
        explain("edge", backend="reference")


def test_planes_that_are_given_are_never_changed() -> None:
    x, u = picture_of(40), picture_of(40)
    kept = x.copy(), u.copy()
    for choices in (
        {},
        {"scheme": "rk4"},
        {"cell": "full-range"},
        {"mask": x > 0},
        {"step": 0.1},
        {"without": ["sleep"]},
    ):
        end = run_transient(Template(np.full((3, 3), 0.3), 0.2), state=x, input=u, duration=2.0, **choices)
        end.x[:] = 7
        assert np.array_equal(x, kept[0])
        assert np.array_equal(u, kept[1])
    nothing = run_transient(Template(np.full((3, 3), 0.3)), state=x, duration=0.0)
    nothing.x[:] = 7
    assert np.array_equal(x, kept[0])


def test_a_trajectory_keeps_its_planes() -> None:
    for template in (Template(np.full((3, 3), 0.3)), library.load("median").network):
        x = picture_of(12)
        wanted = [y.copy() for _, y in trajectory(template, state=x, input=x, until=2.0, frames=4)]
        found = []
        for _, y in trajectory(template, state=x, input=x, until=2.0, frames=4):
            found.append(y.copy())
            x[:] = 0
        assert all(np.array_equal(a, b) for a, b in zip(found, wanted, strict=True))


def test_frames_count_as_planes() -> None:
    frames = Frames([picture_of(9) for _ in range(3)], 1.0)
    task = make_task(Template([[1]], [[1]]), state=frames.planes[0], input=frames, duration=3.0)
    assert len(task.planes) == 3
