"""Memory of a transient on a backend, given planes and result included."""

from cnnsim.backends.term_table import TermTable, longest_delay, table_of
from cnnsim.planning.plan import Plan

MASK_BYTES, MASK_BYTES_AS_VALUES = 1.125, 1.0
"""Bytes a cell of a mask: as truth values and bits where it is given, and as truth values on the cpu backend."""


def cell_bytes(plan: Plan, given: int, itemsize: int, *, has_mask: bool = False, backend: str = "cpu") -> float:
    """Return the bytes a cell of a transient in numbers of ``itemsize`` bytes with ``given`` planes.

    On OpenCL the given planes and the result are memory of the device; if that is the processor, they are not copied.
    """
    mask = MASK_BYTES if has_mask else 0.0
    if backend == "opencl":
        return (given + device_planes(plan)) * itemsize + mask
    return (given + working_planes(plan)) * itemsize + mask + (MASK_BYTES_AS_VALUES if has_mask else 0.0)


def working_planes(plan: Plan) -> float:
    """Return the planes of each layer that a transient on the cpu backend makes: its result, w = B*u + z, and the plane
    with which the steps alternate.

    Terms with a delay keep a plane for each step of the longest; each local weight is a plane. The reference backend,
    which is for small grids, keeps more.
    """
    if plan.method == "closed form":
        return 1
    if plan.method != "general":
        return 3
    return 3 + _delay(plan) + _of_terms(plan)


def device_planes(plan: Plan) -> float:
    """Return the planes that a transient on the opencl backend makes on the device in addition to those it is given.

    A stepped transient of one stage makes w = B*u + z and two states. Other steps make, of states and of outputs, a
    plane for each step of the longest delay and for up to two stages; w and its padded copy, or padded inputs; a sum of
    stages; and the result.
    """
    if plan.method == "closed form":
        return 4 if plan.template.control_terms else 1
    stages = 1 if plan.scheme is None else len(plan.scheme.b)
    if plan.method != "general" and stages == 1:
        return 3
    channels = [channel for table in _tables(plan) for channel in table.channels] if plan.network else []
    delay = max((channel.ago for channel in channels if channel.quantity != "u"), default=0)
    inputs = len({channel.ago for channel in channels if channel.quantity == "u"}) if plan.network else 1
    ring = (delay + 2 if delay or stages == 1 else 1) + min(2, stages - 1)
    rates = stages if plan.scheme is not None and plan.scheme.keeps_rates else 0
    sums = 1 + rates if stages > 1 else 0
    weights = _local_weights(plan) if plan.network else 0
    return (1 if plan.cell == "discrete-time" else 2) * ring + sums + inputs + weights + 2


def _delay(plan: Plan) -> int:
    assert plan.network is not None
    return longest_delay(plan, plan.network)


def _of_terms(plan: Plan) -> float:
    """Return the planes a layer for local weights, and for inputs that are read at several times."""
    planes = _local_weights(plan)
    for table in _tables(plan):
        times = {channel.ago for channel in table.channels if channel.quantity == "u"}
        planes += len(times) if len(times) > 1 else 0
    return planes


def _local_weights(plan: Plan) -> float:
    """Return the planes a layer for weights that differ from cell to cell."""
    return sum(len(table.planes) for table in _tables(plan)) / _layers(plan)


def _tables(plan: Plan) -> list[TermTable]:
    return [table_of(plan, plan.template.A.dtype, static=still) for still in (True, False)]


def _layers(plan: Plan) -> int:
    assert plan.network is not None
    return len(plan.network.layers)
