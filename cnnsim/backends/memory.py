"""Memory of a transient on a backend: the planes it keeps, what was given and what comes out included."""

from cnnsim.backends.term_table import TermTable, longest_delay, table_of
from cnnsim.planning.plan import Plan

MASK_BYTES, MASK_BYTES_AS_VALUES = 1.125, 1.0
"""Bytes a cell of a mask: as truth values where it is checked, and as bits; the closed form and the first outputs of
discrete time take it as truth values once more."""


def cell_bytes(plan: Plan, given: int, itemsize: int, *, has_mask: bool = False, backend: str = "cpu") -> float:
    """Return the bytes a cell of a transient in numbers of ``itemsize`` bytes, with so many planes ``given``.

    The opencl backend has what is given, and the result, on the device and outside of it: where the device is the
    processor, both are the same memory.
    """
    mask = MASK_BYTES if has_mask else 0.0
    if backend == "opencl":
        return (2 * given + device_planes(plan) + 1) * itemsize + mask
    values = has_mask and (plan.method == "closed form" or plan.cell == "discrete-time")
    return (given + working_planes(plan)) * itemsize + mask + (MASK_BYTES_AS_VALUES if values else 0.0)


def working_planes(plan: Plan) -> float:
    """Return the planes that a transient on the cpu backend makes besides those it is given: its result, w = B*u + z,
    and a plane more, since the steps go from one to the other. Of layers there are as many each.

    Terms with a delay keep a plane for each step of the longest, terms with local weights have a plane a weight. The
    reference backend, which is for small grids, keeps more.
    """
    if plan.method == "closed form":
        return 1
    if plan.method != "general":
        return 3
    return 3 + _delay(plan) + _of_terms(plan)


def device_planes(plan: Plan) -> float:
    """Return the planes that a transient on the opencl backend makes on the device besides those it is given."""
    stages = _stages(plan)
    if plan.method == "general":
        # the first outputs, and three by turns; or the state and the next one by turns, all rates, a stage
        steps = 4 if plan.cell == "discrete-time" else 2 + stages + (stages > 1)
        return 1 + _delay(plan) + steps + _on_device(plan)
    if plan.method == "closed form":
        return 1 + _control(plan)
    kept = stages - 1 if plan.scheme is not None and plan.scheme.keeps_rates else 0
    return 3 + _control(plan) + min(stages - 1, 2) + kept  # w, the steps by turns, a stage and the next one


def _stages(plan: Plan) -> int:
    return 1 if plan.scheme is None else len(plan.scheme.b)


def _control(plan: Plan) -> int:
    """Return the planes of terms of the input: their sum; what it is made from has gone when steps begin."""
    return 1 if plan.template.control_terms else 0


def _delay(plan: Plan) -> int:
    assert plan.network is not None
    return longest_delay(plan, plan.network)


def _of_terms(plan: Plan) -> float:
    """Return the planes, a layer, of weights that differ from cell to cell; and of inputs, where terms look at those of
    several times at once.
    """
    planes = 0.0
    for table in _tables(plan):
        times = {channel.ago for channel in table.channels if channel.quantity == "u"}
        planes += len(table.planes) / _layers(plan) + (len(times) if len(times) > 1 else 0)
    return planes


def _on_device(plan: Plan) -> float:
    """Return the planes, a layer, of channels, one at least of the input and of the state, and of weights."""
    return sum(max(1, len(table.channels)) + len(table.planes) for table in _tables(plan)) / _layers(plan)


def _tables(plan: Plan) -> list[TermTable]:
    return [table_of(plan, plan.template.A.dtype, static=still) for still in (True, False)]


def _layers(plan: Plan) -> int:
    assert plan.network is not None
    return len(plan.network.layers)
