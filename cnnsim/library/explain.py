"""explain: how a template would be computed on a grid, and how long it takes by theory; nothing is computed."""

from dataclasses import dataclass
from typing import Unpack

import numpy as np
from numpy.typing import ArrayLike

from cnnsim.keywords import spelled
from cnnsim.library.catalogue import load
from cnnsim.library.entry import LibraryEntry
from cnnsim.network import AnyTemplate, layered
from cnnsim.planning.plan import Plan, lines_of
from cnnsim.theory.running_time import RunningTime
from cnnsim.transient import TaskOptions, make_task


@dataclass(frozen=True)
class Explanation:
    """A ``plan`` with its decisions, and the ``guaranteed`` running time; ``str`` has a line for each."""

    plan: Plan
    guaranteed: RunningTime

    def __str__(self) -> str:
        return lines_of([*self.plan.decisions, ("guaranteed time", str(self.guaranteed))])


@spelled(TaskOptions)
def explain(
    template: str | LibraryEntry | AnyTemplate, picture: ArrayLike = (64, 64), **changes: Unpack[TaskOptions]
) -> Explanation:
    """Return what the plan decides for a template on a grid, and why.

    Arguments: ``template`` a name or an entry of the library, or a template of your own, whose time no theory tells
    here; ``picture`` CNN values (rows, cols), or only the shape (rows, cols); ``changes`` as in `run_transient`.

    Raises:
        InputError: no such template, or as `run_transient`.
    """
    values = np.asarray(picture)
    values = -np.ones(values) if values.ndim == 1 else values
    if not isinstance(template, str | LibraryEntry):
        layers = len(layered(template).layers)
        state = np.broadcast_to(values, (layers, *values.shape[-2:])) if layers > 1 else values
        choices: TaskOptions = {"input": state, **changes}
        return Explanation(
            make_task(template, state=state, **choices).plan,
            RunningTime(None, "a file says what u and x(0) are; this template has none"),
        )
    entry = load(template) if isinstance(template, str) else template
    if entry.frame_time and values.ndim == 2:
        values = np.stack([values, values])
    roles = entry.initial_state if isinstance(entry.initial_state, tuple) else (entry.initial_state,)
    planes = entry.task(values, -np.ones(values.shape[-2:]) if "given" in roles else None)
    plan = make_task(entry.network, **{**planes, **changes}).plan
    return Explanation(plan, entry.running_time(plan.shape))
