"""Gradient of a loss of a template's outputs by its weights and planes."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Unpack

import numpy as np
from numpy.typing import ArrayLike

from cnnsim import backends
from cnnsim.backends.base import check_finite
from cnnsim.learning.adjoint import AdjointTransient, weights_of, with_weights
from cnnsim.learning.losses import Loss, checked_target, loss_of
from cnnsim.network import AnyTemplate, Frames
from cnnsim.planning.step import check_whole_steps
from cnnsim.prototyping.functions import Subject, entry_of
from cnnsim.support import Array, InputError
from cnnsim.support.keywords import spelled
from cnnsim.support.values import is_number
from cnnsim.task import Dtype, Task, TaskOptions, make_task


@dataclass(frozen=True, eq=False, repr=False)
class Gradient:
    """The ``loss`` and its derivatives.

    ``template`` holds the derivatives by A, B, z and the weights of terms in their places. ``state``, ``input`` (None
    without one) and ``bias`` are those by x(0), u and the bias map; of a sequence they are `Frames`. ``y`` are the
    outputs at the times of the loss, ``t`` is the end of the transient.
    """

    loss: float
    template: AnyTemplate
    state: Array
    input: Array | Frames[Array] | None
    bias: Array | Frames[Array]
    y: Array
    t: float

    def __repr__(self) -> str:
        return f"Gradient(loss {self.loss:.6g} at t = {self.t:g}, {self.template!r})"


@spelled(TaskOptions)
def gradient(
    subject: Subject, pictures: ArrayLike, targets: ArrayLike, loss: Loss = "squares", *,
    state: ArrayLike | None = None, times: Sequence[float] | None = None, dtype: Dtype = "float64",
    **changes: Unpack[TaskOptions],
) -> Gradient:  # fmt: skip
    """Return the derivatives of a loss by A, B, z, bias, u and x(0), by the discrete adjoint of the transient.

    The derivative is that of the steps that are computed, so it is exact but for rounding; a steady state is that
    after the steps that settling takes. Templates with a closed form are stepped as well. The cpu computes it. States
    of up to 256 MB are kept, of longer transients 2 sqrt(steps) states, which are computed twice. Brendel, Roska and
    Bartfai, Neural Processing Letters 16 (2002) 111.

    Arguments: ``subject``, a name, an entry or a template (u and x(0) are then the picture, zero flux); ``pictures``
    (rows, cols) or (n, rows, cols); ``targets``, of the shape of the outputs, from -1 to 1, with ``times`` (times,
    *shape); ``loss`` as in `loss_of`; ``state``, the second picture; ``times`` of the loss [time constants], None for
    the end; ``changes`` as in `run`.

    Raises:
        InputError: planes or targets that do not fit; a network without derivatives; it has not settled.
    """
    entry = entry_of(subject)
    if changes.get("accuracy") is not None:
        raise InputError("gradient with an accuracy; scheme and step, or neither, wanted")
    moments = None if times is None else _moments(times)
    if moments is not None:
        changes.setdefault("duration", max(moments))
    given = entry.changed(
        entry.task(pictures, state), {**changes, "without": [*changes.get("without", ()), "closed form"]}
    )
    given.pop("accuracy", None)
    task = make_task(entry.network, **given)
    steps = _steps(task, dtype)
    at = (steps,) if moments is None else _at(moments, task, steps)
    run = AdjointTransient(task, steps, dtype)
    network = run.network
    states = run.forward(weights_of(network), np.array([layer.z for layer in network.layers]), at)
    check_finite(states[at[-1]], steps * task.plan.step)
    x = np.stack([states[step].reshape(task.state.shape) for step in at])
    x = x[0] if times is None else x
    value, bar = loss_of(loss, x, checked_target(targets, x.shape), task.plan.characteristic)
    bars: dict[int, Array] = {}
    for step, part in zip(at, bar[None] if times is None else bar, strict=True):
        bars[step] = bars.get(step, 0) + np.asarray(part, run.dtype).reshape(run.state.shape)
    pulled = run.backward(bars)

    def planes(found: list[Array], value: Any) -> Any:
        shaped = [plane.reshape(task.state.shape) for plane in found]
        return _frames(shaped, run.starts, value, task.plan.step) if isinstance(value, Frames) else sum(shaped)

    return Gradient(
        value, with_weights(entry.network, pulled.weights, pulled.z), pulled.state.reshape(task.state.shape),
        None if task.input is None else planes(pulled.input, task.input), planes(pulled.bias, task.bias),
        task.plan.output(x), steps * task.plan.step,
    )  # fmt: skip


def _frames(found: list[Array], starts: list[int], value: Frames[Any], step: float) -> Frames[Array]:
    """Return the derivatives by the planes of a sequence from those by the planes of spans."""
    sums = [np.zeros_like(found[0]) for _ in value.planes]
    for first, plane in zip(starts, found, strict=True):
        sums[min(first // round(value.period / step), len(sums) - 1)] += plane
    return Frames(sums, value.period)


def _steps(task: Task, dtype: Dtype) -> int:
    if task.plan.duration != "settled":
        return task.plan.steps
    mirrored = task.plan.boundary.kind == "reflecting"
    outcome = task.start(backends.get("reference") if mirrored else backends.chosen("cpu", dtype, None))
    if not outcome.settled:
        name = task.plan.template.name
        raise InputError(f"template {name!r} has not settled after {outcome.t:g} time constants; give a duration")
    return round(outcome.t / task.plan.step)


def _moments(times: Sequence[float]) -> list[float]:
    if (
        not isinstance(times, Sequence | np.ndarray)
        or not len(times)
        or not all(is_number(t) and t >= 0 for t in times)
    ):
        raise InputError(f"times {times!r}; a list of numbers of time constants >= 0 wanted")
    return [float(t) for t in times]


def _at(moments: list[float], task: Task, steps: int) -> tuple[int, ...]:
    check_whole_steps([t for t in moments if t], task.plan.step)
    at = tuple(round(t / task.plan.step) for t in moments)
    if max(at) > steps:
        raise InputError(f"times up to {max(moments):g}, but the transient ends at {steps * task.plan.step:g}")
    return at
