"""Prototyping from Python: design a template, measure its robustness and its accuracy, trace its transient."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import asdict, dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike

from cnnsim import backends, library
from cnnsim.library.entry import LibraryEntry
from cnnsim.network import AnyTemplate, Boundary, LayeredTemplate, Template, fixed
from cnnsim.prototyping.accuracy.work_precision import PrecisionRow, measured, reference_state, settings
from cnnsim.prototyping.design.decompose import design_rule
from cnnsim.prototyping.design.design import Design
from cnnsim.prototyping.design.expression import parse_rule
from cnnsim.prototyping.design.linear import Norm
from cnnsim.prototyping.design.rule import WindowRule
from cnnsim.prototyping.design.rule_files import as_pair, rule_of_pairs
from cnnsim.prototyping.robust.error_rate import shown_to
from cnnsim.prototyping.robust.report import Robustness
from cnnsim.prototyping.robust.robust import measure
from cnnsim.prototyping.trace.trace import record, watching_time
from cnnsim.support import InputError
from cnnsim.task import make_task
from cnnsim.trajectories import Trajectory

if TYPE_CHECKING:
    from matplotlib.axes import Axes

Subject = str | LibraryEntry | AnyTemplate | Design
"""What can be examined: a name of the library, an entry, a template, or a design of one template."""
WHITE = fixed(-1)
Setting = tuple[str, str, str, float]
"""Backend, dtype, scheme and step of a run."""
STEPS_PER_SCHEME = 8


def design(
    rule: str | WindowRule | Sequence[tuple[ArrayLike, ArrayLike]], *, boundary: Boundary = WHITE,
    norm: Norm = "sum",
) -> Design:  # fmt: skip
    """Design the templates of a rule on the 3 x 3 window, with the largest relative margin.

    Arguments: ``rule``, a text such as ``"c and not n"``, a `WindowRule`, or pairs of an input and an output picture
    (rows, cols) of CNN values; ``boundary`` of the pictures; ``norm`` of the weights to which the margin is relative.

    Raises:
        InputError: a rule that cannot be read, or pairs that contradict each other.
    """
    if isinstance(rule, str):
        found = parse_rule(rule)
    elif isinstance(rule, WindowRule):
        found = rule
    else:
        found = rule_of_pairs([as_pair(pair) for pair in rule], boundary)
    return design_rule(found, norm)


def robust(
    subject: Subject, pictures: ArrayLike | None = None, *, state: ArrayLike | None = None, draws: int = 40,
    seed: int = 0,
) -> Robustness:  # fmt: skip
    """Measure the share of wrong cells under errors of the weights, few bits and noise.

    Arguments: ``subject``; ``pictures`` (rows, cols) or (n, rows, cols) on which it is judged, None for all
    neighbourhoods or its own examples; ``state``, the second picture; ``draws`` of random errors a level; ``seed``.

    Raises:
        InputError: no such template, or one that cannot be judged without pictures.
    """
    entry = entry_of(subject)
    if pictures is None:
        return measure(entry, draws=draws, seed=seed)
    planes = np.asarray(pictures, float)
    planes = planes if planes.ndim > 2 else planes[None]
    shown = shown_to(entry, planes, None if state is None else np.asarray(state, float))
    return measure(entry, draws=draws, seed=seed, shown=shown)


def trace(
    subject: Subject, picture: ArrayLike, *, state: ArrayLike | None = None, duration: float | None = None,
    frames: int = 120, layer: int = 0, backend: str = "cpu", **changes: Any,
) -> Trajectory:  # fmt: skip
    """Record the states of a transient at ``frames`` + 1 evenly spaced times.

    Arguments: ``subject``; ``picture`` and ``state`` (rows, cols); ``duration`` [time constants], None for a little
    longer than outputs change; ``layer`` of a network of layers; ``changes`` as in `cnnsim.run`.

    Raises:
        InputError: no such template, a picture it does not take, or no duration above 0.
    """
    entry, where = entry_of(subject), backends.get(backend)
    task = make_task(entry.network, **entry.changed(entry.task(picture, state), changes))
    return record(task, where, watching_time(task, where) if duration is None else duration, frames, layer)


@dataclass(frozen=True, repr=False)
class WorkPrecision:
    """Runs of one transient by scheme, step and dtype: ``rows``, and ``reference``, how the exact state was found."""

    title: str
    rows: tuple[PrecisionRow, ...]
    reference: str

    def __repr__(self) -> str:
        return f"WorkPrecision({self.title!r}, {len(self.rows)} runs, exact state: {self.reference})"

    def table(self) -> list[dict[str, Any]]:
        """Return a dictionary of each run: backend, dtype, scheme, step, error, signs, evaluations, seconds."""
        return [asdict(row) for row in self.rows]

    def _repr_html_(self) -> str:
        from cnnsim.plot.html import heading, table  # used by notebooks only

        rows = [
            [f"{value:.3g}" if isinstance(value, float) else str(value) for value in row.values()]
            for row in self.table()
        ]
        return heading(self.title, f"exact state: {self.reference}") + table(rows, list(self.table()[0]))

    def plot(self, axes: Axes | None = None, against: str = "seconds") -> Axes:
        """Draw the error against ``against``, "seconds" or "evaluations"; return the axes."""
        from cnnsim.plot.figures import given_or_new  # slow to import
        from cnnsim.prototyping.accuracy.plot import draw

        drawn = given_or_new(axes)
        draw(self.rows, drawn, against, self.title)
        return drawn


def accuracy(
    subject: Subject, picture: ArrayLike, *, duration: float | None = None, names: Sequence[str] = ("cpu",),
    track: Callable[[Sequence[Setting]], Iterable[Setting]] = iter,
) -> WorkPrecision:  # fmt: skip
    """Measure time and error of all schemes, steps and dtypes on a picture.

    Arguments: ``subject``, a network of one layer; ``picture`` (rows, cols), a small one; ``duration`` [time
    constants], None for the template's own, or 10; ``names`` of backends; ``track`` wraps the list of runs, for a
    progress bar.

    Raises:
        InputError: a network of several layers, in discrete time or for sequences; no step is stable.
    """
    entry = entry_of(subject)
    if entry.frame_time is not None or isinstance(entry.initial_state, tuple) or entry.cell.model == "discrete-time":
        raise InputError(
            f"template {entry.name!r} takes a sequence, layers or discrete time; one layer that runs on wanted"
        )
    task = entry.task(picture, picture if entry.initial_state == "given" else None)
    given: dict[str, Any] = {"template": entry.network} | task
    for key in ("step", "accuracy", "limit"):
        given.pop(key, None)
    given["duration"] = duration or (10.0 if given["duration"] == "settled" else given["duration"])
    exact, how = reference_state(given)
    runs = list(settings(names, STEPS_PER_SCHEME))
    rows = tuple(row for row in (measured(given, exact, setting) for setting in track(runs)) if row is not None)
    if not rows:
        spread = f"{runs[0][3]:g} to {runs[-1][3]:g}"
        raise InputError(f"template {entry.name!r}: no step from {spread} is stable; another one wanted")
    return WorkPrecision(f"{entry.name}, t = {given['duration']:g}", rows, how)


def entry_of(subject: Subject) -> LibraryEntry:
    """Return the library entry of a subject; a template of one's own takes the picture as u and x(0), zero flux.

    Raises:
        InputError: no such template, or a design of several templates.
    """
    if isinstance(subject, LibraryEntry):
        return subject
    if isinstance(subject, Template | LayeredTemplate):
        return LibraryEntry(subject.name or "template", "", "", subject)
    if isinstance(subject, Design):
        if not subject.one_template:
            raise InputError(f"a design of {len(subject.parts)} templates; one template wanted")
        part = subject.parts[0]
        return LibraryEntry("designed", subject.rule.text, "", part.template("designed"), boundary=WHITE,
                            initial_state="given" if part.state == "state" else "any", tags=("binary",))  # fmt: skip
    return library.load(subject)
