"""The general method: the templates that need it, and its scheme and step."""

from collections.abc import Callable, Sequence
from functools import partial

import numpy as np

from cnnsim.network import AnyTemplate, Cell, Characteristic, LayeredTemplate, layered
from cnnsim.network.characteristic import CLIP
from cnnsim.planning.network_modes import network_modes, step_bound
from cnnsim.planning.scheme import ADAPTIVE, EULER, Scheme, find_scheme
from cnnsim.planning.stability import fastest_turning, turning_from, usual_scheme
from cnnsim.planning.step import DEFAULT_STEP, Duration, allowed_step, check_whole_steps, divided, timed_step
from cnnsim.support import InputError


def why_general(template: AnyTemplate, cell: Cell, periods: Sequence[float]) -> str:
    """Return why a template needs the general method, or nothing if it does not."""
    if isinstance(template, LayeredTemplate):
        return f"{len(template.layers)} layers"
    if cell.model == "discrete-time":
        return "a discrete-time cell"
    if cell.output != CLIP:
        return f"output characteristic {cell.output}"
    if periods:
        return "planes that change with time"
    return "; ".join(map(str, template.feedback_terms))


def delays_of(template: AnyTemplate) -> tuple[float, ...]:
    """Return the different delays of the template's terms, the shortest first."""
    return tuple(sorted({term.delay for layer in layered(template).layers for term in layer.terms if term.delay}))


def check_grid(network: LayeredTemplate, grid: tuple[int, int]) -> None:
    """Raise InputError if the weights of a space-variant term are for another grid."""
    for term in (term for layer in network.layers for term in layer.terms):
        if term.weights.ndim == 4 and term.weights.shape[2:] != grid:
            raise InputError(f"a term has weights for {term.weights.shape[2:]} cells; the grid has {grid}")


def decide_general(
    network: LayeredTemplate, cell: Cell, why: str, scheme: str | None, step: float | None,
    duration: Duration, periods: Sequence[float], grey: Callable[[], bool],
) -> tuple[Scheme | None, float, list[tuple[str, str]]]:  # fmt: skip
    """Return the scheme (None: discrete time, or adaptive), the step and the decisions of the general method.

    Raises:
        InputError: choices that cannot be combined.
    """
    decisions, delays = [("general method", why)], delays_of(network)
    timed = bool(periods or delays)
    if timed and duration == "settled":
        raise InputError("a delay, or planes that change with time: give a duration, such a network does not settle")
    if cell.model == "discrete-time":
        if scheme is not None or step not in (None, 1.0) or set(network.time_constants) != {1.0}:
            raise InputError("discrete-time cells take whole steps: no scheme, no other step, no other time constant")
        check_whole_steps([*delays, *periods, *([] if duration == "settled" else [duration])], 1.0)
        return None, 1.0, [*decisions, ("steps", f"all cells at once, y = {cell.output}")]
    if scheme == ADAPTIVE:
        if duration == "settled" or timed:
            raise InputError("the adaptive scheme runs for a number of time constants, without delays and sequences")
        return None, 1.0, [*decisions, ("adaptive", "DOP853 of scipy with relative tolerance 1e-10: a reference")]
    limit_of = partial(step_bound, network, cell.output, duration)
    modes = network_modes(network, cell.output)
    turning = turning_from(partial(fastest_turning, modes, duration, allowed_step(step)), grey)
    if scheme is None and not delays:
        table = usual_scheme(limit_of, min(DEFAULT_STEP, allowed_step(step)), turning)
    else:
        table = EULER if scheme is None else find_scheme(scheme)
    longest, forced = limit_of(table), scheme is not None
    h, reason = timed_step(table, step, longest, duration, delays, periods, turning, forced=forced)
    h = h if timed else divided(duration, h)
    decisions.append((f"{table.name}, h = {h:.4g}", f"order {table.order}; the step is {reason}"))
    if jump := largest_jump(network, cell.output):
        decisions.append(
            ("chatter", f"drives jump by up to {jump:g}: states swing by about step x jump = {h * jump:.3g}")
        )
    return table, h, decisions


def largest_jump(network: LayeredTemplate, output: Characteristic) -> float:
    """Return the largest jump of a drive at the edge of a step of one table or one output."""
    jumps = [0.0]
    for layer in network.layers:
        jumps += [term.jump for term in layer.feedback_terms]
        jumps.append(output.jump * float(np.abs(layer.A).max()))
    return max(jumps)
