"""Progress of a run in supersteps: its time, the rate, what is left, and the blocks asleep."""

from time import perf_counter
from typing import Any

from cnnsim.support.progress import watcher

_UNITS = ((86400.0, "d"), (3600.0, "h"), (60.0, "min"), (1.0, "s"))


class _Clock:
    """When the run began, and at which step, to tell its rate."""

    run, begun, step = "", 0.0, 0


def tell(supersteps: Any, done: int, tasks: int, steps: int) -> None:
    """Tell whoever watches that so many of the tasks of a superstep of so many steps are done."""
    watched_by = watcher()
    if watched_by is None:
        return
    plan, record = supersteps.plan, supersteps.record
    if _Clock.run != supersteps.run:
        _Clock.run, _Clock.begun, _Clock.step = supersteps.run, perf_counter(), record.step
    now = record.step + steps * done / tasks
    seconds, taken = perf_counter() - _Clock.begun, now - _Clock.step
    rate = taken * plan.shape[0] * plan.shape[1] / max(seconds, 1e-9)
    asleep = len(supersteps.store.blocks) - tasks
    words = f"t = {now * plan.step:.4g}, {rate:.3g} cell steps/s"
    if plan.duration == "settled":
        watched_by(None, f"{words}, {asleep} of {len(supersteps.store.blocks)} blocks asleep")
        return
    left = seconds * (plan.steps - now) / max(taken, 1e-9)
    words = f"{words}, {in_time(left)} left, {asleep} of {len(supersteps.store.blocks)} blocks asleep"
    watched_by(min(1.0, now / max(plan.steps, 1)), words)


def in_time(seconds: float) -> str:
    """Return a time as people read it: 40 s, 3 h."""
    size, unit = next(((size, unit) for size, unit in _UNITS if seconds >= size), _UNITS[-1])
    return f"{seconds / size:.2g} {unit}"
