"""Training of templates on pairs of pictures: random starts, L-BFGS-B on the objective, and its record."""

import json
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from time import process_time
from typing import Any

import numpy as np

from cnnsim.learning.objective import Disturbance, Objective, Timing
from cnnsim.learning.snap import snapped
from cnnsim.learning.training_task import TrainingTask
from cnnsim.network import Frames, Template
from cnnsim.network.boundary import parse_boundary
from cnnsim.planning.step import Duration
from cnnsim.support import Array, Floats, InputError
from cnnsim.support.command_files import own_files
from cnnsim.support.files import write_text
from cnnsim.support.progress import watcher
from cnnsim.transient import run_transient


@dataclass(frozen=True, eq=False, repr=False)
class Training:
    """Trained templates, one a stage: ``wrong`` of ``cells`` outputs are of the wrong colour, ``error`` is their RMS.

    ``curve`` has the objective after each iteration of the start that won, ``snapped`` the grid of the weights (0 if
    they are not on one), ``seconds`` the processor time.
    """

    task: TrainingTask
    templates: tuple[Template, ...]
    wrong: int
    cells: int
    error: float
    curve: tuple[float, ...]
    starts: int
    snapped: float
    seconds: float

    def __repr__(self) -> str:
        return f"Training({self.task.name!r}, {self.wrong} of {self.cells} cells wrong, {list(self.templates)})"

    def __call__(self, pictures: Array, second: Array | None = None) -> Array:
        """Return the outputs for pictures (rows, cols) or (n, rows, cols), as the written file gives them."""
        return outputs(self.task, self.templates, pictures, second)[-1]

    def write(self, folder: Path, *, replace: bool = False) -> list[Path]:
        """Write a template file, of several stages also a program, and the record of the training; return the paths.

        Raises:
            InputError: a file is there and not to be replaced, or the folder cannot be written.
        """
        from cnnsim.learning.files import write_training

        return write_training(self, folder, overwrite=replace)


def outputs(task: TrainingTask, templates: Sequence[Template], picture: Array, second: Array | None) -> list[Array]:
    """Return the outputs of all stages: settled ones for black and white, else after the stage's duration.

    Of sequences they are those at the end, or (times, rows, cols) at the times of the task.
    """
    found: list[Array] = []
    frames = None if task.frame_time is None else Frames(list(picture), task.frame_time)
    for stage, template in zip(task.stages, templates, strict=True):
        before = found[-1] if found else picture
        first = before if frames is None else frames.planes[0]
        shown, state = (
            {"picture": plane, "given": second}[source] if isinstance(source, str) else np.full(first.shape, source)
            for source, plane in ((stage.input, frames or before), (stage.initial_state, first))
        )
        duration: Duration = "settled" if task.binary and frames is None else stage.duration

        def after(duration: Duration, template: Template = template, given: tuple[Any, Any] = (state, shown)) -> Array:
            around = parse_boundary(task.boundary)
            ran = run_transient(
                template, state=given[0], input=given[1], boundary=around, duration=duration, dtype="float64"
            )
            return ran.y

        found.append(np.stack([after(t) for t in task.times]) if task.times else after(duration))
    return found


def train(task: TrainingTask, record: Path | None = None) -> Training:
    """Train templates on pairs of pictures or sequences by the gradient of the whole transient.

    The best of all starts is returned. A start ends the search if all cells of black and white pictures are right.
    Their weights are then snapped to as coarse a grid as keeps that and the margin. ``record`` is a file that is
    written during the training; an unfinished one of the same task is resumed.

    Raises:
        InputError: the record is of another task.
    """
    from scipy.optimize import minimize

    begun, search = process_time(), _Search(task, record)
    bounds = [(low, task.largest) for low in np.where(search.centre & task.binary, 1.0, -task.largest)]
    while search.start < task.starts and not (task.binary and search.best and search.best["wrong"] == 0):
        minimize(
            search.objective, search.current(), jac=True, method="L-BFGS-B", bounds=bounds, callback=search.after,
            options={"maxiter": max(1, task.iterations - len(search.curve)), "maxls": 30},
        )  # fmt: skip
        search.finish()
    templates, snapped_to = search.templates(search.best["numbers"]), 0.0
    if task.binary and search.best["wrong"] == 0:
        templates, snapped_to = snapped(templates, task.stages, lambda found: search.judge(found)[0] == 0)
    wrong, error = search.judge(templates)
    cells = sum(pair.target.size for pair in task.pairs)
    return Training(task, templates, wrong, cells, error, tuple(search.best["curve"]), search.start, snapped_to,
                    process_time() - begun)  # fmt: skip


class _Search:
    """The starts so far, the best numbers, and the present ones."""

    def __init__(self, task: TrainingTask, record: Path | None) -> None:
        assert task.loss is not None
        self._task, self._record = task, record
        self.objective = Objective(
            task.pairs, task.stages, parse_boundary(task.boundary), task.loss, Disturbance(task.noise, task.mismatch),
            (task.decay, task.sparsity), task.seed, Timing(task.frame_time, tuple(task.times)),
        )  # fmt: skip
        self.centre = np.concatenate([stage.self_feedback for stage in task.stages])
        self.start, self.curve, self._now = 0, list[float](), list[float]()
        self.best: dict[str, Any] = {}
        if record is not None and record.exists():
            self._resume(record)

    def _resume(self, record: Path) -> None:
        try:
            found = json.loads(record.read_text(encoding="utf-8"))
            if found.get("finished"):
                return
            digest = found["task"]
            self.start, self.curve, self._now, self.best = (found[key] for key in ("start", "curve", "now", "best"))
        except (ValueError, KeyError, TypeError, AttributeError) as error:
            raise InputError(f"{record} is no record of a training; another folder or name wanted") from error
        if digest != self._task.digest:
            raise InputError(f"{record} is the record of another training; another folder or name wanted")

    def current(self) -> Floats:
        """Return the numbers from which to go on: those of the record, or random ones."""
        if self._now:
            return np.array(self._now)
        rng = np.random.default_rng([self._task.seed, self.start])
        first = 0.5 * rng.standard_normal(self.centre.size)
        first = np.where(self.centre & self._task.binary, 1 + np.abs(first), first)
        in_terms = np.concatenate([stage.in_terms for stage in self._task.stages])
        return np.clip(np.where(in_terms, 0.0, first), -self._task.largest, self._task.largest)

    def after(self, now: Floats) -> None:
        """Record an iteration and report the progress."""
        self.curve.append(self.objective.last)
        self._now = now.tolist()
        if (report := watcher()) is not None:
            task = self._task
            share = (self.start + len(self.curve) / task.iterations) / task.starts
            report(min(1.0, share), f"start {self.start + 1}, objective {self.curve[-1]:.3g}")
        self._save()

    def finish(self) -> None:
        """Judge the end of a start, and keep it if it is the best."""
        now = self._now or self.current().tolist()
        wrong, error = self.judge(self.templates(now))
        if not self.best or (wrong, error) < (self.best["wrong"], self.best["error"]):
            self.best = {"wrong": wrong, "error": error, "numbers": now, "curve": self.curve}
        self.start, self.curve, self._now = self.start + 1, [], []
        self._save()

    def _save(self) -> None:
        if self._record is not None:
            data = {
                "task": self._task.digest,
                "start": self.start,
                "curve": self.curve,
                "now": self._now,
                "best": self.best,
            }
            with own_files():
                write_text(self._record, json.dumps(data), replace=True)

    def templates(self, numbers: Sequence[float]) -> tuple[Template, ...]:
        """Return the templates for all free numbers."""
        stages, several = self._task.stages, len(self._task.stages) > 1
        parts = np.split(np.array(numbers), np.cumsum(self.objective.sizes)[:-1])
        names = [f"{self._task.name}-{n + 1}" if several else self._task.name for n in range(len(stages))]
        return tuple(s.with_numbers(part, name) for s, part, name in zip(stages, parts, names, strict=True))

    def judge(self, templates: Sequence[Template]) -> tuple[int, float]:
        """Return how many outputs have the wrong colour (grey: 0), and the root mean square of their errors."""
        wrong, squares, cells = 0, 0.0, 0
        for pair in self._task.pairs:
            try:
                y = outputs(self._task, templates, pair.picture, pair.given)[-1]
            except InputError:  # unstable, or not settled
                y = np.zeros(pair.target.shape)
            wrong += int((y * pair.target <= 0).sum()) if self._task.binary else 0
            squares, cells = squares + float(((y - pair.target) ** 2).sum()), cells + y.size
        return wrong, float(np.sqrt(squares / cells))
