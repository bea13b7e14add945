"""The integration step: the longest stable one or the one requested, fitted to duration, delays and frames."""

from collections.abc import Sequence
from fractions import Fraction
from math import ceil, gcd, inf, lcm
from typing import Literal

from cnnsim.planning.scheme import Scheme
from cnnsim.support import InputError
from cnnsim.support.notices import Notices
from cnnsim.support.values import is_number

Duration = float | Literal["settled"]
"""A number of time constants, or until the network has settled."""

DEFAULT_STEP = 0.1
MOST_STEPS = 10**12
"""Most steps of a transient: more would take years on the smallest grid."""


def allowed_step(step: float | None) -> float:
    """Return the step whose error decides the scheme: the one requested, or the default."""
    return step if is_number(step) and 0 < step < inf else DEFAULT_STEP


def usual_step(scheme: Scheme, longest: float, turning: float) -> float:
    """Return the default step: half the stability limit ``longest``, a sixth of it for schemes of order 4.

    Schemes of order 4 are chosen for oscillating modes, which h |omega| = 1/2 follows to three digits. ``turning`` is
    the largest |omega| to follow, or 0.
    """
    if scheme.order < 4:
        return min(DEFAULT_STEP, longest / 2)
    return min(DEFAULT_STEP, longest / 6, 0.5 / turning if turning else inf)


def check_count(time: float, h: float) -> None:
    """Raise InputError if a time takes more than `MOST_STEPS` steps of length ``h``."""
    if time > MOST_STEPS * h:
        raise InputError(f"{time:g} time constants in steps of {h:g}; at most {MOST_STEPS:.0e} steps wanted")


def divided(duration: Duration, h: float) -> float:
    """Shorten the step where the duration is not a multiple of it, so that the last step ends on time."""
    if duration == "settled" or duration == 0:
        return h
    check_count(duration, h)
    steps = max(1, ceil(duration / h - 1e-9))
    return h if steps > 1 and abs(steps * h - duration) <= 1e-9 * duration else duration / steps


def check_step(step: float, longest: float, scheme: Scheme, verdict: str, *, forced: bool = False) -> None:
    """Raise InputError for a step that is not positive or is longer than ``longest``: then it ``verdict``.

    A ``forced`` step may be longer; one warning is issued.
    """
    if not is_number(step) or not 0 < step < inf:
        raise InputError(f"step {step!r}; a positive number of time constants wanted")
    if step > longest * (1 + 1e-9):
        what = f"step {step:g} {verdict}: {scheme.name} on this template"
        if not forced:
            cure = "; name the scheme as well to force it" if verdict == "may be unstable" else ""
            raise InputError(f"{what} needs a step below {longest:.6g}{cure}")
        Notices.once(f"{what} is certainly stable below {longest:.6g}")


def timed_step(
    scheme: Scheme, step: float | None, longest: float, duration: Duration, delays: Sequence[float],
    periods: Sequence[float], turning: float, *, forced: bool,
) -> tuple[float, str]:  # fmt: skip
    """Return the step of a network that may have delays and sequences, and the reason for it.

    Delays and holding times are whole numbers of steps: nothing is interpolated. ``turning`` as in `usual_step`,
    ``forced`` as in `check_step`.

    Raises:
        InputError: a step that may be unstable and is not forced, or does not divide a delay or a holding time; a delay
            with a scheme whose stages are between steps.
    """
    if delays and not set(scheme.matrix.sum(axis=1)) <= {0.0, 1.0}:
        raise InputError(
            f"{scheme.name} has stages between the steps, where delayed values are unknown; use euler or heun"
        )
    times = [*delays, *periods]
    if times and duration != "settled" and duration:
        times.append(duration)
    if step is None:
        most = usual_step(scheme, longest, turning)
        check_count(max(times, default=0.0), most)
        h = common_step(times, most) if times else most
        why = f"at most {most:.4g}" + (" and divides all delays and holding times" if times else "")
        return h, why + (f", for modes that oscillate at {turning:.3g} a time constant" if turning else "")
    check_step(step, longest, scheme, "may be unstable", forced=forced)
    check_whole_steps(times, step)
    return step, f"as requested; certainly stable below {longest:.4g}"


def is_whole_steps(times: Sequence[float], step: float) -> bool:
    """Return whether all times are whole numbers of steps."""
    return all(abs(max(1, round(time / step)) * step - time) <= 1e-9 * time for time in times)


def check_whole_steps(times: Sequence[float], step: float) -> None:
    """Raise InputError if a time is no whole number of steps; the message has the nearest ones."""
    for time in times:
        if not is_whole_steps([time], step):
            count = max(1, round(time / step))
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
    h = float(whole) / ceil(float(whole) / most - 1e-9) if whole > most else float(whole)
    if h < most / 1000:
        raise InputError(
            f"the times {', '.join(f'{time:g}' for time in times)} have no common step above {most / 1000:g}"
        )
    return float(h)
