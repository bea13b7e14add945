"""Run: the states of a transient at whole steps, some of them kept, the others recomputed exactly from those."""

import time
from dataclasses import replace
from functools import lru_cache

import numpy as np

from cnnsim.backends.base import Backend
from cnnsim.network import Frames
from cnnsim.planning.general import delays_of
from cnnsim.planning.plan import Plan
from cnnsim.planning.step import DEFAULT_STEP
from cnnsim.solver.solve import solve_at
from cnnsim.support import Array
from cnnsim.task import Task

MOST_STATES, MOST_KEPT = 1024, 96 * 2**20
"""Number and bytes of the kept states; beyond them every second one is dropped."""


class Run:
    """A transient that goes forward and back; ``x`` is the state after ``index`` steps of length ``step``.

    ``first`` is the index of the first state, ``state`` if given: what was changed while it ran begins there. A state
    that has no time loop (closed form, adaptive, an accuracy) is computed from the first state for its time, a network
    with delays or sequences from the first state by steps, any other from the nearest kept state before it.
    """

    def __init__(self, task: Task, backend: Backend, first: int = 0, state: Array | None = None) -> None:
        plan = task.plan
        self.task = task if state is None else replace(task, state=state)
        self.backend, self.first = backend, first
        discrete = plan.cell == "discrete-time"
        self.by_time = task.accuracy is not None or (plan.scheme is None and not discrete)
        self.timed = any(isinstance(value, Frames) for value in (task.input, task.bias)) or (
            plan.network is not None and bool(delays_of(plan.network))
        )
        self.restarts = self.by_time or self.timed or (discrete and not plan.characteristic.keeps_outputs)
        self.step = DEFAULT_STEP if self.by_time else plan.step
        self.x: Array = backend.read(backend.load(self.task.state, "lam"))
        self.index, self._stride = first, 1
        self.kept: dict[int, Array] = {first: self.x}
        self.seconds, self.cell_steps = 0.0, 0
        self._pace = 1
        self._of = lru_cache(64)(self._shortened)  # a backend prepares a plan once

    @property
    def t(self) -> float:
        """The time of the state [time constants]."""
        return self.index * self.step

    @property
    def y(self) -> Array:
        """The output."""
        return self.task.plan.output(self.x)

    @property
    def last(self) -> int | None:
        """The index at the end of a fixed duration; None if the network runs until it settles."""
        duration = self.task.plan.duration
        return None if duration == "settled" else round(duration / self.step)

    def go(self, index: int, seconds: float = np.inf) -> bool:
        """Go to the state after ``index`` steps; return False if the time is over before it is reached."""
        index = max(index, self.first)
        if index == self.index:
            return True
        if index < self.index or self.restarts:
            before = max(i for i in self.kept if i <= index) if not self.restarts else self.first
            self.index, self.x = (index, self.kept[index]) if index in self.kept else (before, self.kept[before])
        until = time.perf_counter() + seconds
        while self.index < index:
            begin = time.perf_counter()
            count = index - self.index if self.restarts else min(index - self.index, self._pace)
            self.x = self._after(count)
            self.index += count
            self._keep()
            took = time.perf_counter() - begin
            self.seconds += took
            self.cell_steps += count * self.x.size
            self._pace = (
                min(1024, 2 * self._pace) if took < 0.01 else max(1, self._pace // 2) if took > 0.04 else self._pace
            )
            if time.perf_counter() > until:
                break
        return self.index == index

    def settled(self) -> bool:
        """Return whether nothing changes any more (see `Plan`).

        False where delays or sequences may change it, and for the adaptive scheme, which does not look for rest.
        """
        plan = self.task.plan
        adaptive = plan.scheme is None and plan.method != "closed form" and plan.cell != "discrete-time"
        if self.timed or adaptive:
            return False
        end = self.task.start(self.backend, self.x, replace(plan, duration="settled", limit=0.0))
        if plan.method != "closed form":
            return end.settled
        return bool(np.abs(plan.output(self.backend.read(end.x)) - self.y).max() < 1e-3)  # it ends at infinity

    def states(self, indices: list[int]) -> list[Array]:
        """Return the states after ascending numbers of steps; the run stays where it is."""
        index, x, found = self.index, self.x, []
        for one in indices:
            self.go(one)
            found.append(self.x)
        self.index, self.x = index, x
        return found

    def _after(self, count: int) -> Array:
        if self.task.accuracy is not None:
            found = solve_at(self.task.problem(), self.backend, self.task.accuracy, count * self.step)[1]
            return np.asarray(found.x)
        return self.backend.read(self.task.start(self.backend, self.x, self._of(count)).x, copy=False)

    def _shortened(self, count: int) -> Plan:
        plan = self.task.plan
        return replace(plan, duration=count * self.step, savings=plan.savings - {"sleep"})

    def _keep(self) -> None:
        if self.index - max(i for i in self.kept if i <= self.index) < self._stride:
            return
        self.kept[self.index] = self.x
        if len(self.kept) > MOST_STATES or len(self.kept) * self.x.nbytes > MOST_KEPT:
            every = sorted(self.kept)
            self.kept = {i: self.kept[i] for i in every[::2]}
            self._stride *= 2
