"""A transient to an accuracy: the cheapest way that is known to reach it, and how near the run says it came."""

import math
from dataclasses import replace

import numpy as np

from cnnsim.accuracy.choice import choose
from cnnsim.accuracy.closed_form import by_closed_form
from cnnsim.accuracy.corrected import by_corrected_steps, is_correctable, is_corrected
from cnnsim.accuracy.kink_to_kink import affordable_kinks, by_kinks
from cnnsim.accuracy.ladder import Ladder
from cnnsim.accuracy.plain_signs import CELLS, by_plain_signs
from cnnsim.accuracy.repeatable import LEAST_CELLS, Reached, Repeatable, largest
from cnnsim.accuracy.stairs import by_stairs, has_stairs
from cnnsim.accuracy.steps import by_steps, longest_step
from cnnsim.accuracy.to_rest import to_rest
from cnnsim.accuracy.uncoupled.jumps import jumps_of_last_digits
from cnnsim.accuracy.wanted import Wanted
from cnnsim.backends import in_float64
from cnnsim.backends.base import Backend, check_finite
from cnnsim.planning.general import delays_of
from cnnsim.planning.plan import Plan
from cnnsim.planning.scheme import HEUN, RK4, Scheme
from cnnsim.support import Array, Flags, InputError

_CHEAP = 3.0
"""How much longer the step of the run is from which, and the one that counts, the error is seen."""


def reach(transient: Repeatable, backend: Backend, wanted: Wanted) -> Reached:
    """Run a transient to an accuracy on a backend, in float64 where float32 cannot give it.

    Raises:
        InputError: a device without float64 where that is needed; a state that comes out as no finite number.
    """
    where, told, plan = backend, "", transient.plan
    if wanted.dtype == "float64" and backend.dtype != "float64":
        where, told = in_float64(backend), f"; in float64, as float32 cannot give {wanted}"
        if where.dtype != "float64":
            raise InputError(f"accuracy {wanted}: the device has no float64, and float32 cannot give it")
    jumps = jumps_of_last_digits(plan, transient.planes[0].shape, transient.planes[1], where.dtype)
    if jumps is not None and (finer := in_float64(backend)).dtype != where.dtype:
        where, told = finer, "; in float64, as inputs lie at the edge of a step of a table"
        jumps = jumps_of_last_digits(plan, transient.planes[0].shape, transient.planes[1], where.dtype)
    if plan.cell == "discrete-time":
        found = transient.once(where, "discrete time has no error")
    elif plan.method == "closed form":
        found = by_closed_form(transient, where, jumps)
    elif plan.duration and has_stairs(plan) and (exact := by_stairs(transient, where)) is not None:
        found = exact
    elif plan.duration == "settled":
        found = to_rest(transient, where, wanted)
    elif not plan.duration:
        found = transient.once(where, "no time goes by")
    elif not is_corrected(transient) and (sample := transient.sample()) is not None:
        plain = by_plain_signs(transient, where) if wanted.signs else None
        found = plain or _by_sample(transient, sample, where, wanted)
    else:
        found = _by_steps(transient, where, wanted)
    if jumps is not None:
        edge = found.undecided & (jumps > 0) if plan.method == "closed form" else transient.free(jumps > 0)
        found = replace(found, undecided=found.undecided | edge)
        told += f"; at {int(edge.sum())} cells the last digit of the input decides"
    check_finite(found.x, found.t)  # float32 may not hold what steps in float64 find
    how = f"accuracy {wanted}: {found.how}{told}"
    return replace(found, undecided=transient.free(found.undecided), how=how)


def _ladder(transient: Repeatable, where: Backend, plans: list[Plan], scheme: Scheme = RK4) -> Ladder:
    """Return the runs of a transient by a scheme (with delays by Heun); each appends its plan."""
    plan, divides = transient.plan, transient.timed
    scheme = HEUN if divides and delays_of(plan.network) else scheme  # type: ignore[arg-type]  # timed plans have one
    longest = plan.step if divides else longest_step(plan, scheme)

    def run(step: float) -> Array:
        if (
            plans and plans[-1].scheme == scheme and len(scheme.b) > 1
        ):  # what a step of several stages saves does not depend on its length
            plans.append(replace(plans[-1], step=step))
        else:
            plans.append(by_steps(plan, scheme, step, timed=divides))
        end = transient.start(where, plans[-1], transient.pushed(where, 0.5, len(plans)))
        return where.read(end.x)

    floor = float(np.finfo(where.dtype).eps) * max(1.0, largest(transient.planes[0])) * 4
    duration = float(plan.duration)
    return Ladder(
        run, transient.planes[0], plan.output, duration, min(longest, duration), divides, floor, scheme.order,
        held=transient.planes[3],
    )  # fmt: skip


def _by_steps(transient: Repeatable, where: Backend, wanted: Wanted) -> Reached:
    plan, plans = transient.plan, list[Plan]()
    kinks = affordable_kinks(plan, wanted) if transient.planes[0].ndim == 2 else 0
    if kinks > 0 and (exact := by_kinks(transient, kinks)) is not None:
        return replace(exact, x=exact.x.astype(where.dtype), error=max(exact.error, float(np.finfo(where.dtype).eps)))
    corrected = is_corrected(transient)
    quick = wanted.signs and (not corrected or transient.planes[0].size >= CELLS)
    if quick and (plain := by_plain_signs(transient, where)) is not None:
        return plain
    if corrected:
        return by_corrected_steps(transient, where, wanted)
    ladder = _ladder(transient, where, plans)
    error, unsure, reached = ladder.climb(wanted)
    how = _how(ladder, plans[-1], wanted, reached)
    return Reached(ladder.ends[-1], float(plan.duration), False, math.nan, error, unsure, plans[-1], how)


def _by_sample(transient: Repeatable, sample: Repeatable, where: Backend, wanted: Wanted) -> Reached:
    """Choose scheme and step on the sample; see on the whole grid, by a longer step first, how near that comes.

    What one cell near a ridge does no sample knows, so where it is too far off rk4 goes on by shorter steps.
    """
    pilot, plan, plans = _ladder(sample, where, []), transient.plan, list[Plan]()
    if pilot.divides:
        return _by_steps(transient, where, wanted)

    def planned(scheme: Scheme, step: float) -> Plan:
        return by_steps(sample.plan, scheme, step)

    choice, rk4_step = choose(pilot, lambda again: where.read(sample.start(where, again).x), planned, wanted.error)
    scheme = choice.plan.scheme or RK4
    ladder = _ladder(transient, where, plans, scheme)
    error, unsure, reached = _climbed(ladder, choice.plan.step, wanted, once=scheme != RK4)
    if not reached and scheme != RK4:
        ladder = _ladder(transient, where, plans)
        error, unsure, reached = _climbed(ladder, rk4_step, wanted)
    windows, side = len(sample.planes[0]), " x ".join(map(str, sample.plan.shape))
    how = _how(ladder, plans[-1], wanted, reached) + f"; chosen on {windows} windows of {side} cells"
    return Reached(ladder.ends[-1], float(plan.duration), False, math.nan, error, unsure, plans[-1], how)


def _climbed(ladder: Ladder, step: float, wanted: Wanted, *, once: bool = False) -> tuple[float, Flags, bool]:
    """Climb from a step that a sample speaks for, after one that is longer and cheap."""
    ladder.believed, ladder.most = 2, 2 if once else ladder.most
    ladder.take_near(step * _CHEAP)
    ladder.take_near(min(step, 0.5 * ladder.steps[0]))  # two steps that are nearly alike would always agree
    return ladder.climb(wanted)


def _how(ladder: Ladder, plan: Plan, wanted: Wanted, reached: bool) -> str:
    assert plan.scheme is not None
    taken = ", ".join(f"{step:.3g}" for step in ladder.steps)
    how = f"{plan.scheme.name} by steps of {taken}; the last two runs differ by {ladder.differences[-1]:.2g}"
    return how if reached else f"{how}; {wanted} was not reached"


def decided(plan: Plan, wanted: Wanted, shape: tuple[int, ...]) -> tuple[str, str]:
    """Return what an accuracy decides about a plan for a state of a shape, and why, for people."""
    cells = math.prod(plan.shape)
    if plan.cell == "discrete-time" or plan.method == "closed form":
        why = "the plan's own, which is exact"
    elif has_stairs(plan):
        why = "each cell from jump to jump of its drive, exactly, if the input stays"
    elif plan.duration == "settled":
        why = (
            "one run where theory knows one end (no output turns round, or there is one rest), else two by different "
            f"steps, which must end alike, within {wanted} of the rest"
        )
    elif cells >= LEAST_CELLS and plan.method == "stepped" and not is_correctable(plan, shape):
        why = "the cheapest scheme and step that reach it on a sample of windows, whose errors are measured"
    else:
        corrected = is_correctable(plan, shape)
        kinks_do = "with its kinks corrected (order 3)" if corrected else "(kinks cost order 4 down to 2)"
        why = f"rk4 {kinks_do} by shorter and shorter steps until two runs agree"
        if (kinks := affordable_kinks(plan, wanted)) > 0:
            why = f"from kink to kink if there are at most {kinks}, which costs less; else {why}"
    return f"accuracy {wanted}", f"{why}; {wanted.dtype} or more"
