"""Memory of a transient on a backend: the planes it keeps, what was given and what comes out included."""

from cnnsim.backends.term_table import longest_delay, table_of
from cnnsim.planning.plan import Plan

MASK_BYTES, MASK_BYTES_IN_LOOPS = 1.125, 1.0
"""Bytes a cell of a mask: as truth values where it is checked, and as bits; loops of the cpu backend that read no bits
take it as truth values once more."""


def cell_bytes(plan: Plan, given: int, itemsize: int, *, has_mask: bool = False, backend: str = "cpu") -> float:
    """Return the bytes a cell of a transient in numbers of ``itemsize`` bytes, with so many planes ``given``.

    The opencl backend has what is given, and the result, on the device and outside of it: where the device is the
    processor, both are the same memory.
    """
    mask = MASK_BYTES if has_mask else 0.0
    if backend == "opencl":
        return (2 * given + device_planes(plan) + 1) * itemsize + mask
    loops = MASK_BYTES_IN_LOOPS if has_mask and plan.method != "stepped" else 0.0
    return (given + working_planes(plan)) * itemsize + mask + loops


def working_planes(plan: Plan) -> float:
    """Return the planes that a transient on the cpu backend makes besides those it is given: its result, w = B*u + z,
    steps in between.

    The reference backend, which is for small grids, keeps more.
    """
    if plan.method == "general":
        stages = _stages(plan)
        steps = 3 if plan.cell == "discrete-time" else 1 + (stages + 1 if stages > 1 else 0)
        delay = _delay(plan)
        return (delay + 1 if delay else 0) + 1 + steps + _of_terms(plan)
    if plan.method == "closed form":
        return 1 + _control(plan)
    return 3 + _control(plan)  # w, and two planes between which the steps go by turns


def device_planes(plan: Plan) -> float:
    """Return the planes that a transient on the opencl backend makes on the device besides those it is given."""
    stages = _stages(plan)
    if plan.method == "general":
        # the first outputs, and three by turns; or the state and the next one by turns, all rates, a stage
        steps = 4 if plan.cell == "discrete-time" else 2 + stages + (stages > 1)
        return 1 + _delay(plan) + steps + _of_terms(plan, least=1)
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


def _of_terms(plan: Plan, least: int = 0) -> float:
    """Return the planes of channels, so many at ``least`` of the input and of the state, and of weights, a layer."""
    assert plan.network is not None
    tables = [table_of(plan, plan.template.A.dtype, static=still) for still in (True, False)]
    return sum(max(least, len(table.channels)) + len(table.planes) for table in tables) / len(plan.network.layers)
