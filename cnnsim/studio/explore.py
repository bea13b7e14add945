"""Robustness and accuracy of a template on the page's own picture: one chip, or one setting, a request."""

from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np

from cnnsim import backends
from cnnsim.network import layered
from cnnsim.prototyping.accuracy.work_precision import measured, reference_state
from cnnsim.prototyping.robust.disturb import with_relative_errors
from cnnsim.prototyping.trace.trace import watching_time
from cnnsim.studio.message import Message
from cnnsim.studio.setup import Setup
from cnnsim.support import Array, InputError

if TYPE_CHECKING:
    from cnnsim.studio.session import Session

_LIMIT = 100.0
_GREY = 0.1
"""An output is wrong when it has another sign, or where it is grey, when it moves by more than this."""
SIDE = 64
"""Side of the middle of a larger picture on which accuracy is measured."""
SETTINGS = tuple((scheme, 0.8 * 0.5**k) for k in range(6) for scheme in ("euler", "exponential-euler", "heun", "rk4"))


Precision = tuple[dict[str, Any], Array, str]
"""The arguments of a run, the exact state at its end, and how that was found."""


class Chips:
    """Runs of chips whose entries have relative errors of a standard deviation, each with a seed of its own."""

    def __init__(self, setup: Setup, sigma: float, seed: int) -> None:
        self.sigma, self.seed, self.count = sigma, seed, 0
        settles = {"limit": _LIMIT} if setup.entry.duration == "settled" else {}
        self._task = setup.task(without=["shared sums"], **settles)  # a disturbed A is no longer isotropic
        self._backend = backends.get()
        self._network = setup.entry.network
        self.right = self._output(self._network)
        self.failed = np.zeros(self.right.shape, np.int64)
        self.wrong: list[int] = []

    def add(self) -> None:
        """Run one more chip."""
        rng = np.random.default_rng([self.seed, self.count])
        try:
            y = self._output(with_relative_errors(self._network, self.sigma, rng))
            wrong = np.where(np.abs(self.right) > 0.99, y * self.right <= 0, np.abs(y - self.right) > _GREY)
        except InputError:  # the run diverged
            wrong = np.ones(self.right.shape, bool)
        self.failed += wrong
        self.wrong.append(int(wrong.sum()))
        self.count += 1

    def _output(self, template: Any) -> Array:
        plan, network = self._task.plan, layered(template)
        plan = replace(plan, template=network.layers[0], network=None if plan.network is None else network)
        return np.asarray(plan.output(self._backend.read(self._task.start(self._backend, plan=plan).x)))


def _chip(session: "Session", message: Message) -> Message:
    """Run one more chip; reply with how often each cell has failed, 255 for always."""
    sigma, seed = message.number("sigma", 0, 1), message.whole("seed", 0, 10**9, 0)
    chips = session.chips
    if chips is None or message.content.get("first") is True or (chips.sigma, chips.seed) != (sigma, seed):
        chips = session.chips = Chips(session.setup, sigma, seed)
    chips.add()
    shown = session.layer(chips.failed, message)
    good = sum(wrong == 0 for wrong in chips.wrong)
    content = {"is": "chips", "count": chips.count, "good": good, "wrong": chips.wrong[-1], "cells": chips.right.size,
               "share": sum(chips.wrong) / (chips.count * chips.right.size), "shape": shown.shape}  # fmt: skip
    data = np.ceil(shown * (255 / chips.count)).astype(np.uint8)
    return Message(content, [data.tobytes()])


def _precision(session: "Session", message: Message) -> Message:
    """Measure one setting of `SETTINGS` on the middle of the picture; reply with its error and time.

    Raises:
        InputError: a template for sequences.
    """
    number = message.whole("number", 0, len(SETTINGS) - 1)
    setup = session.setup
    if setup.picture.ndim == 3:
        raise InputError("accuracy against time is measured on one picture, not on a sequence")
    if number == 0 or session.precision is None:
        session.precision = _reference(setup)
    given, exact, how = session.precision
    scheme, step = SETTINGS[number]
    row = measured(given, exact, ("cpu", "float64", scheme, step), rounds=2)
    found = None if row is None else {"error": row.error, "seconds": row.seconds, "evaluations": row.evaluations,
                                      "signs": row.signs}  # fmt: skip
    content = {"is": "precision", "number": number, "of": len(SETTINGS), "scheme": scheme, "step": step, "row": found,
               "reference": how, "time": given["duration"], "shape": exact.shape[-2:]}  # fmt: skip
    return Message(content)


def _reference(setup: Setup) -> Precision:
    rows, cols = setup.grid
    top, left = max(0, (rows - SIDE) // 2), max(0, (cols - SIDE) // 2)
    where = np.s_[top : top + SIDE, left : left + SIDE]
    second = None if setup.second is None else setup.second[where]
    small = replace(setup, picture=setup.picture[where], second=second, scheme=None)
    task = small.task(accuracy=None)
    duration = min(watching_time(task, backends.get()), 30.0)
    entry = replace(small.entry, step=None, accuracy=None, duration=duration)
    if second is None and small.takes_second:
        second = np.full(small.grid, -1.0)
    given = entry.task(small.picture, second if small.takes_second else None)
    given = {**given, "template": entry.network}
    return (given, *reference_state(given))


HANDLERS = {"chip": _chip, "precision": _precision}
