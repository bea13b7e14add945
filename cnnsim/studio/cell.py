"""One cell of a run: its state over time, what its neighbours contribute, and its dynamic route."""

from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np

from cnnsim.backends.reference.terms import ReferenceNetwork
from cnnsim.network import Boundary, layered
from cnnsim.network.boundary import virtual_index
from cnnsim.network.cell import rate
from cnnsim.network.frames import at_step
from cnnsim.studio.message import Message
from cnnsim.studio.run import Run
from cnnsim.support import Array, InputError

if TYPE_CHECKING:
    from cnnsim.studio.session import Session

SAMPLES = 150
"""States over time, at most."""
POINTS = 161
"""Values of x of a dynamic route."""
_SAME = 0.01
"""An output is final when it stays within this of its present value."""


def cell_facts(run: Run, row: int, col: int, layer: int = 0) -> dict[str, Any]:
    """Return the facts of a cell at the present time, as lists of numbers.

    Keys: ``t``, ``x``, ``y``, ``feedback`` (sum of A*y) and ``control`` (sum of B*u) over time; ``A``, ``B`` and ``z``,
    the contributions by neighbour; ``drive``; ``route``; ``final``, the time from which the output stays.

    Raises:
        InputError: weights that differ from cell to cell.
    """
    template = layered(run.task.plan.network or run.task.plan.template).layers[layer]
    if any(term.weights.ndim == 4 for term in template.terms):
        raise InputError("the weights of a term differ from cell to cell: the cell view shows equal ones only")
    every = max(1, -(-(run.index - run.first) // SAMPLES))
    steps = [*range(run.first, run.index, every), run.index]
    patches = [_patch(run, x, row, col) for x in run.states(steps)]
    r = patches[0].shape[-1] // 2
    x = np.array([patch[layer, r, r] for patch in patches], np.float64)
    y = np.array([run.task.plan.output(patch)[layer] for patch in patches], np.float64)
    inputs = [_input_patch(run, step, row, col, patches[0].shape)[layer] for step in steps]
    feedback = [_weighted(template.A, plane) for plane in y]
    control = [_weighted(template.B, plane) for plane in inputs]
    outputs = y[:, r, r]
    moving = np.flatnonzero(np.abs(outputs - outputs[-1]) > _SAME)
    drive = _drives(run, patches[-1], x[-1:], row, col, layer)[0]
    known = feedback[-1].sum() + control[-1].sum() + template.z
    return {
        "row": row, "col": col, "t": [step * run.step for step in steps], "x": x.tolist(), "y": outputs.tolist(),
        "feedback": [float(part.sum()) for part in feedback], "control": [float(part.sum()) for part in control],
        "A": feedback[-1].tolist(), "B": control[-1].tolist(), "z": template.z, "terms": float(drive - known),
        "drive": float(drive), "every": every, "route": _route(run, patches[-1], float(x[-1]), row, col, layer),
        "final": 0.0 if not moving.size else steps[min(moving[-1] + 1, len(steps) - 1)] * run.step,
    }  # fmt: skip


def _route(run: Run, patch: Array, x: float, row: int, col: int, layer: int) -> dict[str, Any]:
    """Return dx/dt against x of the cell, with its neighbours as they are, and the equilibria.

    Chua and Yang, "Cellular neural networks: theory", IEEE Trans. CAS 35 (1988) 1257, fig. 7. Discrete-time cells have
    none.
    """
    plan = run.task.plan
    if plan.cell == "discrete-time":
        return {"x": [], "rate": [], "equilibria": []}
    reach = 1.0 if plan.cell == "full-range" else max(2.5, 1.2 * abs(x))
    points = np.unique(np.concatenate([np.linspace(-reach, reach, POINTS), [-1.0, 1.0]]))
    network = layered(plan.network or plan.template)
    drives = _drives(run, patch, points, row, col, layer)
    rates = rate(drives, points, plan.cell) / network.time_constants[layer]
    found = []
    for left, right, a, b in zip(points[:-1], points[1:], rates[:-1], rates[1:], strict=True):
        if a == 0 or a * b < 0:
            at = left if a == 0 else left - a * (right - left) / (b - a)
            found.append({"x": float(at), "stable": bool(b < a)})
    return {"x": points.tolist(), "rate": rates.tolist(), "equilibria": found[:20]}


def _drives(run: Run, patch: Array, points: Array, row: int, col: int, layer: int) -> Array:
    """Return the drive of the cell for values of its state, with its neighbours as in the patch."""
    plan, side = run.task.plan, patch.shape[-1]
    small = replace(plan, network=layered(plan.network or plan.template), shape=(side, side))
    x = np.broadcast_to(patch, (len(points), *patch.shape)).copy()
    x[:, layer, side // 2, side // 2] = points
    u = np.broadcast_to(_input_patch(run, run.index, row, col, patch.shape), x.shape)
    return ReferenceNetwork(small, x, u, None, None).drive(x, 0)[:, layer, side // 2, side // 2]


def _patch(run: Run, x: Array, row: int, col: int) -> Array:
    """Return the states (layers, side, side) around a cell; the side is of the template's radius."""
    plan = run.task.plan
    r = (plan.network or plan.template).radius
    return _window(x if x.ndim == 3 else x[None], row, col, r, plan.boundary, plan.boundary.y)


def _input_patch(run: Run, step: int, row: int, col: int, shape: tuple[int, ...]) -> Array:
    """Return the input of the same shape."""
    task, boundary = run.task, run.task.plan.boundary
    if task.input is None:
        return np.zeros(shape)
    held = np.asarray(at_step(task.input, step - 1, task.plan.step))
    planes = held if held.ndim == 3 else np.broadcast_to(held, (shape[0], *held.shape))
    return _window(planes, row, col, shape[-1] // 2, boundary, boundary.u)


def _window(planes: Array, row: int, col: int, r: int, boundary: Boundary, constant: float) -> Array:
    places = zip(planes.shape[-2:], (row, col), strict=True)
    i, j = (virtual_index(cells, r, boundary)[at : at + 2 * r + 1] for cells, at in places)
    patch = planes[..., i[:, None], j].astype(np.float64)
    patch[..., (i < 0)[:, None] | (j < 0)] = constant
    return patch


def _weighted(weights: Array, patch: Array) -> Array:
    """Return weights (side, side) times the middle of a patch."""
    r, middle = len(weights) // 2, patch.shape[-1] // 2
    if r > middle:  # zeros around
        weights, r = weights[r - middle : r + middle + 1, r - middle : r + middle + 1], middle
    return weights * patch[middle - r : middle + r + 1, middle - r : middle + r + 1]


def _cell(session: "Session", message: Message) -> Message:
    rows, cols = session.setup.grid
    row, col = message.whole("row", 0, rows - 1), message.whole("col", 0, cols - 1)
    layer = message.whole("layer", 0, session.layers() - 1, 0)
    return Message({"is": "cell", **cell_facts(session.run, row, col, layer)})


HANDLERS = {"cell": _cell}
