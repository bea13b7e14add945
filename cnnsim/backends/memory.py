"""Memory of a transient on the cpu backend: the planes it keeps, what was given and what comes out included."""

from cnnsim.backends.term_table import longest_delay, table_of
from cnnsim.planning.plan import Plan

MASK_BYTES, MASK_BYTES_IN_LOOPS = 1.125, 1.0
"""Bytes a cell of a mask: as truth values where it is checked, and as bits; loops that read no bits take it as truth
values once more."""


def cell_bytes(plan: Plan, given: int, itemsize: int, *, has_mask: bool = False) -> float:
    """Return the bytes a cell of a transient in numbers of ``itemsize`` bytes, with so many planes ``given``."""
    mask = MASK_BYTES + MASK_BYTES_IN_LOOPS * (plan.method != "stepped") if has_mask else 0.0
    return (given + working_planes(plan)) * itemsize + mask


def working_planes(plan: Plan) -> float:
    """Return the planes that a transient makes besides those it is given: its result, w = B*u + z, steps in between.

    OpenCL keeps about as many on its device; the reference backend, which is for small grids, more.
    """
    if plan.method == "general":
        return _general(plan)
    control = 1 if plan.template.control_terms else 0  # their sum; what it is made from has gone when steps begin
    if plan.method == "closed form":
        return 1 + control
    return 3 + control  # w, and two planes between which the steps go by turns


def _general(plan: Plan) -> float:
    assert plan.network is not None
    tables = [table_of(plan, plan.template.A.dtype, static=still) for still in (True, False)]
    of_a_layer = sum(len(table.channels) + len(table.planes) for table in tables)
    delay = longest_delay(plan, plan.network)
    stages = 2 if plan.scheme is None else len(plan.scheme.b)
    steps = 3 if plan.cell == "discrete-time" else 1 + (stages + 1 if stages > 1 else 0)
    return (delay + 1 if delay else 0) + 1 + steps + of_a_layer / len(plan.network.layers)
