"""Error rate of a disturbed template: its wrong cells, in closed form on neighbourhoods, or by runs on examples."""

from collections.abc import Sequence
from dataclasses import replace
from typing import Any, Protocol

import numpy as np

from cnnsim import backends
from cnnsim.library.entry import Example, LibraryEntry
from cnnsim.network import AnyTemplate, Frames, Tap, Template, layered
from cnnsim.prototyping.robust.margin import margin_of, works_on_grey
from cnnsim.support import Array, InputError
from cnnsim.task import Task, make_task

MOST_WINDOWS = 4096
_WAIT = 100.0
_GREY = 0.1
"""A twentieth of black to white: more than Euler chatters about the edge of a median, three neighbours of it alike."""


class ErrorRate(Protocol):
    """The share of wrong cells; ``what`` names the cells."""

    what: str

    def share_of_wrong(self, template: AnyTemplate, noise: float, rng: np.random.Generator) -> float:
        """Return the share of wrong cells of a disturbed template with Gaussian noise on the picture."""


def error_rate_of(entry: LibraryEntry, seed: int = 0, shown: Sequence[Example] = ()) -> ErrorRate:
    """Return how to measure a template: on the pictures ``shown``, if there are any (see `shown_to`).

    Else on neighbourhoods where it decides without coupling between black and white, and on its own examples where it
    is coupled or works on grey.

    Raises:
        InputError: no picture, and no worked example where one is needed.
    """
    if shown:
        pictures = _pictures(sum(len(one.output if one.input is None else one.input) for one in shown))
        sequence = f"a sequence of {pictures} given"
        return _Examples(entry, shown, sequence if entry.frame_time else f"{_pictures(len(shown))} given")
    if margin_of(entry).value is not None and entry.template.uncoupled and not works_on_grey(entry):
        return _Neighbourhoods(entry, seed)
    count = len(entry.examples)
    what = "its own worked example" if count == 1 else f"its own {count} worked examples"
    return _Examples(entry, entry.examples, what)


def shown_to(entry: LibraryEntry, pictures: Array, state: Array | None = None) -> list[Example]:
    """Return pictures (n, rows, cols) as examples whose expected output is that of the template without errors.

    A template for moving pictures takes all as one sequence. ``state`` is the second picture, for templates with two.

    Raises:
        InputError: a second picture too many or too few, or of another size.
    """
    backend, found = backends.get(), []
    grey = any(example.tolerance is not None for example in entry.examples)  # also where a picture of it is all white
    for picture in [pictures] if entry.frame_time is not None else pictures:
        example = Example(picture, state, picture)
        task = _task(entry, example)
        y: Array = task.plan.output(backend.read(task.start(backend).x))
        decided = not grey and bool((np.abs(y) > 0.99).all())
        found.append(replace(example, output=y, tolerance=None if decided else _GREY))
    return found


def _pictures(count: int) -> str:
    return f"{count} picture{'s' * (count != 1)}"


def final_colour(s: Array, x0: Array, a: float) -> Array:
    """Return the sign of the final output of cells without neighbours: sgn(s + max(a - 1, 0) x0), |x0| <= 1.

    A tie gives 0. Source: Chua and Yang 1988.
    """
    return np.sign(s + max(a - 1.0, 0.0) * x0)


class _Neighbourhoods:
    """All black-and-white neighbourhoods of the taps, or a sample if there are more than 4096."""

    def __init__(self, entry: LibraryEntry, seed: int) -> None:
        self.entry, self.taps = entry, entry.template.control_taps
        self.centre = next((i for i, tap in enumerate(self.taps) if tap.k == tap.l == 0), None)
        if self.centre is None and entry.initial_state == "picture":  # x(0) is the centre, though B does not weigh it
            self.centre = len(self.taps)
            self.taps = (*self.taps, Tap(0, 0, 0.0))
        free = len(self.taps) + (entry.initial_state == "given")
        if 1 << free <= MOST_WINDOWS:
            count = np.arange(1 << free)
            rows = 2.0 * (count[:, None] >> np.arange(free) & 1) - 1
            self.what = f"all {len(rows)} black-and-white neighbourhoods"
        else:
            rows = np.random.default_rng(seed).choice([-1.0, 1.0], (MOST_WINDOWS, free))
            self.what = f"{MOST_WINDOWS} random black-and-white neighbourhoods"
        self.u = rows[:, : len(self.taps)]
        if isinstance(entry.input, int | float):
            self.u = np.full_like(self.u, entry.input)
        if entry.initial_state == "given":
            self.x0 = rows[:, -1]
        elif entry.initial_state == "picture":
            assert self.centre is not None
            self.x0 = rows[:, self.centre]
        else:
            constant = entry.initial_state if isinstance(entry.initial_state, int | float) else 0.0
            self.x0 = np.full(len(rows), float(constant))
        self.right = self._colours(entry.template, self.u, self.x0)

    def share_of_wrong(self, template: AnyTemplate, noise: float, rng: np.random.Generator) -> float:
        assert isinstance(template, Template)
        u, x0 = self.u, self.x0
        if self.entry.initial_state == "any":
            x0 = rng.uniform(-1, 1, x0.shape)
        if noise and self.entry.input == "none":
            x0 = np.clip(x0 + noise * rng.standard_normal(x0.shape), -1, 1)
        elif noise:
            u = u + noise * rng.standard_normal(u.shape)
        return float(np.mean(self._colours(template, u, x0) != self.right))

    def _colours(self, template: Template, u: Array, x0: Array) -> Array:
        r = template.B.shape[0] // 2
        weights = np.array([template.B[r + tap.k, r + tap.l] if tap.weight else 0.0 for tap in self.taps])
        return final_colour(u @ weights + template.z, x0, template.self_feedback)


class _Examples:
    """Whole runs on examples, most often the template's own.

    Black and white is compared with the example, grey with what the undisturbed template makes of it: the tolerance of
    a grey example has the tolerance of theory, not the effect of an error.
    """

    def __init__(self, entry: LibraryEntry, examples: Sequence[Example], whose: str) -> None:
        if not examples:
            raise InputError(
                f"template {entry.name!r} has no worked example to measure it on; give pictures (--picture)"
            )
        self.examples, self.backend = examples, backends.get()
        self.tasks = [_task(entry, example) for example in examples]
        self.plane = "state" if entry.input == "none" else "input"
        cells = sum(example.output.size for example in examples)
        self.what = f"the {'one cell' if cells == 1 else f'{cells} cells'} of {whose}"
        if any(example.tolerance is not None for example in examples):
            self.what += f" (grey, so wrong is what errors move by more than {_GREY:g})"
        self.right = [
            example.output if example.tolerance is None else self._output(task, entry.network)
            for example, task in zip(self.examples, self.tasks, strict=True)
        ]

    def share_of_wrong(self, template: AnyTemplate, noise: float, rng: np.random.Generator) -> float:
        wrong = sum(
            self._wrong(example, right, task, template, noise, rng)
            for example, right, task in zip(self.examples, self.right, self.tasks, strict=True)
        )
        return wrong / sum(example.output.size for example in self.examples)

    def _wrong(
        self, example: Example, right: Array, task: Task, template: AnyTemplate, noise: float, rng: np.random.Generator
    ) -> int:
        if noise:

            def noisy(picture: Array) -> Array:
                return np.clip(picture + noise * rng.standard_normal(picture.shape), -1, 1)

            plane = getattr(task, self.plane)
            shown: Any = plane.map(noisy) if isinstance(plane, Frames) else noisy(plane)
            task = replace(task, state=shown) if self.plane == "state" else replace(task, input=shown)
        try:
            y = self._output(task, template)
        except InputError:
            return right.size  # the run diverged
        if example.tolerance is None:
            return int((y * right <= 0).sum())
        return int((np.abs(y - right) > _GREY).sum())

    def _output(self, task: Task, template: AnyTemplate) -> Array:
        """Run a template; a chip is read out whether it has settled or not."""
        network = layered(template)
        # the plan of the undisturbed template: a new one for each draw would cost more than the run
        plan = replace(task.plan, template=network.layers[0])
        if plan.network is not None:
            plan = replace(plan, network=network)
        y: Array = task.plan.output(self.backend.read(task.start(self.backend, plan=plan).x))
        return y


def _task(entry: LibraryEntry, example: Example) -> Task:
    picture = example.state if example.input is None else example.input
    assert picture is not None
    roles = entry.initial_state if isinstance(entry.initial_state, tuple) else (entry.initial_state,)
    task = entry.task(picture, example.state if "given" in roles else None) | {"limit": _WAIT}
    return make_task(
        entry.network, **task, mask=example.mask,
        bias=example.bias, without=["shared sums"],  # a disturbed A is no longer isotropic
    )  # fmt: skip
