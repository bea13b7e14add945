"""How a template beyond the linear kind is run: why the general road is taken, its step, and what limits the step."""

from collections.abc import Sequence
from fractions import Fraction
from functools import partial
from math import ceil, gcd, inf, lcm

import numpy as np

from cnnsim.network.characteristic import CLIP, Cell, Characteristic
from cnnsim.network.layers import AnyTemplate, LayeredTemplate, layered
from cnnsim.network.template import Template
from cnnsim.planning.duration import Duration
from cnnsim.planning.network_modes import network_modes, products, slopes_of
from cnnsim.planning.scheme import ADAPTIVE, EULER, Scheme, find_scheme
from cnnsim.planning.stability import limit_of, usual_scheme
from cnnsim.support.errors import InputError


def why_general(template: AnyTemplate, cell: Cell, periods: Sequence[float]) -> str:
    """Return why the roads for linear templates will not do, or nothing if they will."""
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
    """Raise InputError if a space-variant term has its weights for another grid."""
    for term in (term for layer in network.layers for term in layer.terms):
        if term.weights.ndim == 4 and term.weights.shape[2:] != grid:
            raise InputError(f"a term has weights for {term.weights.shape[2:]} cells; the grid has {grid}")


def decide_general(
    network: LayeredTemplate, cell: Cell, why: str, scheme: str | None, step: float | None, default: float,
    duration: Duration, periods: Sequence[float],
) -> tuple[Scheme | None, float, list[tuple[str, str]]]:  # fmt: skip
    """Return the scheme (None: discrete time, or adaptive), the step and the decisions of the general road.

    Raises:
        InputError: what does not go together.
    """
    decisions, delays = [("general road", why)], delays_of(network)
    timed = bool(periods or delays)
    if timed and duration == "settled":
        raise InputError("a delay, or planes that change with time: give a duration, there is no rest to wait for")
    if cell.model == "discrete-time":
        if scheme is not None or step not in (None, 1.0) or set(network.time_constants) != {1.0}:
            raise InputError("discrete-time cells take whole steps: no scheme, no other step, no other time constant")
        check_whole_steps([*delays, *periods, *([] if duration == "settled" else [duration])], 1.0)
        return None, 1.0, [*decisions, ("steps", f"all cells at once, y = {cell.output}")]
    if scheme == ADAPTIVE:
        if duration == "settled" or timed:
            raise InputError("the adaptive scheme runs for a number of time constants, without delays and sequences")
        return None, 1.0, [*decisions, ("adaptive", "DOP853 of scipy with relative tolerance 1e-10: a reference")]
    if scheme is None and not delays:
        table = usual_scheme(partial(step_bound, network, cell.output, duration), default)
    else:
        table = EULER if scheme is None else find_scheme(scheme)
    h, reason = general_step(network, cell, table, step, default, duration, periods)
    h = h if timed else divided(duration, h)
    decisions.append((f"{table.name}, h = {h:.4g}", f"order {table.order}; the step is {reason}"))
    if jump := largest_jump(network, cell.output):
        decisions.append(
            ("chatter", f"drives jump by up to {jump:g}: states swing by about step x jump = {h * jump:.3g}")
        )
    return table, h, decisions


def divided(duration: Duration, h: float) -> float:
    """Shorten the step a little where the duration is no multiple of it, so that the last step ends on time."""
    if duration == "settled" or duration == 0:
        return h
    steps = max(1, ceil(duration / h - 1e-9))
    return h if abs(steps * h - duration) <= 1e-9 * duration else duration / steps


def general_step(
    template: AnyTemplate,
    cell: Cell,
    scheme: Scheme,
    step: float | None,
    default: float,
    duration: Duration,
    periods: Sequence[float],
) -> tuple[float, str]:
    """Return the step and why it is that one.

    All delays and the times that planes are held must be whole numbers of steps, so that nothing is interpolated.

    Raises:
        InputError: a step that may be unstable, or that does not divide a delay or a holding time; a scheme whose
            stages do not lie on the steps, with a delay.
    """
    delays, longest = delays_of(template), step_bound(layered(template), cell.output, duration, scheme)
    if delays and not set(scheme.matrix.sum(axis=1)) <= {0.0, 1.0}:
        raise InputError(
            f"{scheme.name} looks between the steps, where delayed values are not known; use euler or heun"
        )
    times = [*delays, *periods]
    if times and duration != "settled" and duration:
        times.append(duration)
    if step is None:
        most = min(default, longest / 2)
        h = common_step(times, most) if times else most
        return h, f"at most {most:.4g}" + (" and divides all delays and holding times" if times else "")
    if not 0 < step < inf:
        raise InputError(f"step {step!r}; a positive number of time constants wanted")
    if step > longest * (1 + 1e-9):
        raise InputError(
            f"step {step:g} may be unstable: {scheme.name} on this template needs a step below {longest:.6g}"
        )
    check_whole_steps(times, step)
    return step, f"as asked; certainly stable below {longest:.4g}"


def check_whole_steps(times: Sequence[float], step: float) -> None:
    """Raise InputError if a time is no whole number of steps; the message has the nearest ones."""
    for time in times:
        count = max(1, round(time / step))
        if abs(count * step - time) > 1e-9 * time:
            raise InputError(
                f"a delay, holding time or duration of {time:g} is {time / step:.6g} steps of {step:g}; a whole number "
                f"wanted, nearest are the time {count * step:g} or the step {time / count:.6g}"
            )


def common_step(times: Sequence[float], most: float) -> float:
    """Return the longest step up to ``most`` that divides all times.

    Raises:
        InputError: it would be shorter than a thousandth of ``most``.
    """
    parts = [Fraction(time).limit_denominator(10**6) for time in times]
    below = lcm(*(part.denominator for part in parts))
    whole = Fraction(gcd(*(int(part * below) for part in parts)), below)
    h = float(whole) / np.ceil(float(whole) / most - 1e-9) if whole > most else float(whole)
    if h < most / 1000:
        raise InputError(
            f"the times {', '.join(f'{time:g}' for time in times)} have no common step above {most / 1000:g}"
        )
    return float(h)


def largest_jump(network: LayeredTemplate, output: Characteristic) -> float:
    """Return the most by which a drive jumps where one table, or one output, is at the edge of a step."""
    jumps = [0.0]
    for layer in network.layers:
        jumps += [term.jump for term in layer.feedback_terms]
        jumps.append(output.jump * float(np.abs(layer.A).max()))
    return max(jumps)


def step_bound(network: LayeredTemplate, output: Characteristic, duration: Duration, scheme: Scheme) -> float:
    """Return a step below which no decaying mode can grow: Gershgorin's circles, with the tables' steepest slopes.

    In a row of the Jacobian the centre is at least d and the rest sums up to at most R, so no decay is faster than
    1 - min(0, d - R), over the layer's time constant. Enough, not necessary: a template may be stable with longer
    steps. Modes that turn while they decay are computed (`network_modes`). Jumps are no part of it: at a jump Euler's
    state swings by about step x jump and stays there.
    """
    fastest = max(
        _decay(layer, output) / time for layer, time in zip(network.layers, network.time_constants, strict=True)
    )
    real = limit_of(np.array([-fastest + 0j]), duration, scheme)
    return min(real, limit_of(network_modes(network, output), duration, scheme))


def _decay(layer: Template, output: Characteristic) -> float:
    steep = output.steepest
    low, high = (-steep, steep) if output.kind == "table" else (0.0, steep)
    diagonal = min(products((layer.self_feedback,) * 2, (low, high)))
    off = steep * sum(abs(tap.weight) for tap in layer.feedback_taps if (tap.k, tap.l) != (0, 0))
    for term in layer.feedback_terms:
        rises = slopes_of(term)
        for argument in {term.of, *((term.times,) if term.times else ())}:
            for k, l, weight in term.taps:
                weights = float(np.min(weight)), float(np.max(weight))
                own = k == l == 0 and term.layer is None and not term.delay
                for quantity, sign, here in ((argument.neighbour, 1, own), (argument.centre, -1, not term.delay)):
                    if quantity in ("x", "y"):
                        slope = products(products(weights, rises), (low, high) if quantity == "y" else (1.0, 1.0))
                        if here:
                            diagonal += min(sign * side for side in slope)
                        else:
                            off += max(map(abs, slope))
    return 1.0 - min(0.0, diagonal - off)
