"""The integration step: the longest that is stable, or the one asked for, made to fit duration, delays and frames."""

from collections.abc import Sequence
from fractions import Fraction
from math import ceil, gcd, inf, lcm

from cnnsim.planning.duration import Duration
from cnnsim.planning.scheme import Scheme
from cnnsim.support import InputError
from cnnsim.support.values import is_number

DEFAULT_STEP = 0.1


MOST_STEPS = 10**12
"""Steps of a transient: more would take years on the smallest of grids."""


def allowed_step(step: float | None) -> float:
    """Return the step whose errors decide on the scheme: the one asked for, or the longest that is chosen."""
    return step if is_number(step) and 0 < step < inf else DEFAULT_STEP


def usual_step(scheme: Scheme, longest: float, turning: float) -> float:
    """Return the step where none is asked for: half of what is stable, a sixth with schemes of order 4.

    Those are taken for modes that turn: at h |omega| = 1/2 they are followed to three digits, at half the limit to one.
    ``turning``: the |omega| of the fastest that is to be followed, which the limit need not know.
    """
    if scheme.order < 4:
        return min(DEFAULT_STEP, longest / 2)
    return min(DEFAULT_STEP, longest / 6, 0.5 / turning if turning else inf)


def check_count(time: float, h: float) -> None:
    """Raise InputError if a time takes more steps of length ``h`` than can be counted or waited for."""
    if time > MOST_STEPS * h:
        raise InputError(f"{time:g} time constants in steps of {h:g}; at most {MOST_STEPS:.0e} steps wanted")


def divided(duration: Duration, h: float) -> float:
    """Shorten the step a little where the duration is no multiple of it, so that the last step ends on time."""
    if duration == "settled" or duration == 0:
        return h
    check_count(duration, h)
    steps = max(1, ceil(duration / h - 1e-9))
    return h if steps > 1 and abs(steps * h - duration) <= 1e-9 * duration else duration / steps


def check_step(step: float, longest: float, scheme: Scheme, verdict: str) -> None:
    """Raise InputError for a step that is not positive, or longer than ``longest``: it then ``verdict``."""
    if not is_number(step) or not 0 < step < inf:
        raise InputError(f"step {step!r}; a positive number of time constants wanted")
    if step > longest * (1 + 1e-9):
        raise InputError(f"step {step:g} {verdict}: {scheme.name} on this template needs a step below {longest:.6g}")


def timed_step(
    scheme: Scheme, step: float | None, longest: float, duration: Duration, delays: Sequence[float],
    periods: Sequence[float], turning: float,
) -> tuple[float, str]:  # fmt: skip
    """Return the step of a network that may have delays and sequences, and why it is that one.

    All delays and the times that planes are held must be whole numbers of steps, so that nothing is interpolated.
    ``turning`` as in `usual_step`.

    Raises:
        InputError: a step that may be unstable, or that does not divide a delay or a holding time; a scheme whose
            stages do not lie on the steps, with a delay.
    """
    if delays and not set(scheme.matrix.sum(axis=1)) <= {0.0, 1.0}:
        raise InputError(
            f"{scheme.name} looks between the steps, where delayed values are not known; use euler or heun"
        )
    times = [*delays, *periods]
    if times and duration != "settled" and duration:
        times.append(duration)
    if step is None:
        most = usual_step(scheme, longest, turning)
        check_count(max(times, default=0.0), most)
        h = common_step(times, most) if times else most
        return h, f"at most {most:.4g}" + (" and divides all delays and holding times" if times else "")
    check_step(step, longest, scheme, "may be unstable")
    check_whole_steps(times, step)
    return step, f"as asked; certainly stable below {longest:.4g}"


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
