"""Guaranteed running times: when every output of a transient is final, for all pictures of a size or for one picture.

Theory gives a time for three kinds of template; for any other the answer is None, with the reason.

* Cells without neighbours: the closed form of each cell, worst case over all black-and-white neighbourhoods. Chua and
  Roska, "Cellular Neural Networks and Visual Computing", Cambridge 2002, ch. 2-3.
* Trigger waves: path length times switching time, see `cnnsim.theory.wave_time`.
* Contractions, sum|A| < 1: the distance from the one equilibrium shrinks at least as exp(-(1 - sum|A|) t).

The times hold for the exact network and for Euler steps of the given length; other schemes differ by their own error.
"""

from dataclasses import dataclass

import numpy as np

from cnnsim.network import Boundary, Template
from cnnsim.network.boundary import correlate
from cnnsim.support import Array, Floats
from cnnsim.theory import wave_time
from cnnsim.theory.neighbourhood import Pair, pairs_of, too_many, weighted_sums

TOLERANCE = 0.01
"""An output that approaches its final value asymptotically counts as final within this distance."""

PROVED = ("fixed", "zero-flux", "periodic")
"""Boundaries of the proofs: virtual cells are constants or copies of real cells."""

_TIE = 1e-9
_TERMS = "it has non-linear, delayed or space-variant terms"


@dataclass(frozen=True)
class RunningTime:
    """``time`` [time constants] after which every output is final, or None; the reason ``why``, and an assumption."""

    time: float | None
    why: str
    assuming: str = ""

    def __str__(self) -> str:
        if self.time is None:
            return f"none: {self.why}"
        return f"{self.time:.4g} time constants: {self.why}" + (f", if {self.assuming}" if self.assuming else "")


def guaranteed_time(
    template: Template, shape: tuple[int, int], boundary: Boundary, *, input: str | float = "picture",  # noqa: A002 - the field's word for u
    initial_state: str | float = "any", step: float = 0.1, has_mask: bool = False,
) -> RunningTime:  # fmt: skip
    """Return the time after which every output is final, for all black-and-white pictures (rows, cols).

    Arguments: ``input`` and ``initial_state`` are the roles of u and x(0), as in a template file; ``step`` is the
    longest Euler step for which the time holds; ``has_mask``: some cells may be masked.
    """
    if answer := _of_template(template, boundary):
        return answer
    found = pairs_of(input, initial_state)
    if isinstance(found, str):
        return RunningTime(None, found)
    if template.uncoupled:
        return _uncoupled(template, boundary, found, initial_state == "any", step)
    first = None
    for pairs, assuming in _fewer_and_fewer(found):
        wave = wave_time.worst_wave(template, shape, boundary, pairs, step, has_mask)
        if wave.time is not None:
            return RunningTime(wave.time, wave.why, assuming)
        first = first or wave
    assert first is not None
    return RunningTime(None, first.why)


def _of_template(template: Template, boundary: Boundary) -> RunningTime | None:
    """Return the time, or the reason for none, that follows from template and boundary; None if pictures matter."""
    if boundary.kind not in PROVED:
        return RunningTime(None, f"no bound is known for a {boundary} boundary")
    return _contraction(template) if template.linear else RunningTime(None, _TERMS)


def time_of_picture(
    template: Template, *, state: Floats, input: Floats | None = None, boundary: Boundary,  # noqa: A002 - u
    bias: Floats | None = None, mask: Array | None = None, step: float = 0.1,
) -> RunningTime:  # fmt: skip
    """Return the time after which every output is final, for these planes (rows, cols).

    ``state`` within [-1, 1], and black and white for templates with neighbours; ``input`` may be grey.
    """
    if answer := _of_template(template, boundary):
        return answer
    drive = np.full(state.shape, template.z) + (0.0 if bias is None else bias)
    if input is not None:
        drive = correlate(input, template.control_taps, boundary, boundary.u, drive)
    masked = np.zeros(state.shape, dtype=bool) if mask is None else mask > 0
    if np.abs(state[~masked]).max(initial=0.0) > 1:
        return RunningTime(None, "a state lies outside [-1, 1]")
    if not template.uncoupled:
        wave = wave_time.wave_of_picture(template, state, drive, masked, boundary, step)
        return RunningTime(wave.time, wave.why)
    times = cell_time(drive[~masked], state[~masked], template.self_feedback, step)
    longest = float(times.max(initial=0.0))
    if not np.isfinite(longest):
        return RunningTime(None, "a cell stands exactly on a tie")
    return RunningTime(longest, "no neighbours: the closed form of the slowest cell")


def cell_time(s: Floats, x0: Floats, a: float, step: float) -> Floats:
    """Return when the outputs of cells without neighbours are final, for dx/dt = -x + a f(x) + s, |x0| <= 1.

    For a > 1 and q = (a - 1) x0 + s the output reaches sgn(q) after ln[((a-1) + |s'|) / |q|] / (a - 1), s' = s sgn(q);
    for a = 1 after (1 - x0 sgn(s)) / |s|; for a < 1 it comes within `TOLERANCE` of clip(s / (1 - a)). An Euler step h
    multiplies by 1 + (a - 1) h where the exact flow multiplies by exp((a - 1) h). Infinite on a tie.
    """
    with np.errstate(divide="ignore", invalid="ignore"):
        if a < 1:
            goal = s / (1 - a)
            ratio = np.abs(x0 - goal) / (TOLERANCE + np.maximum(np.abs(goal) - 1, 0))
            distance, exact = np.log(np.maximum(ratio, 1)), 1 - a
            by_step = -np.log(np.maximum(1 - (1 - a) * step, 1e-12))
        else:
            q = s + (a - 1) * x0
            s, x0 = s * np.sign(q), x0 * np.sign(q)
            if a == 1:
                distance, exact, by_step = (1 - x0) / s, 1.0, step
            else:
                distance = np.log(((a - 1) + s) / np.abs(q))
                exact, by_step = a - 1, np.log1p((a - 1) * step)
            distance = np.where(np.abs(q) < _TIE, np.inf, np.where(x0 >= 1, 0.0, distance))
        return np.maximum(distance / exact, np.ceil(distance / by_step - _TIE) * step)


def _contraction(template: Template) -> RunningTime | None:
    size = float(np.abs(template.A).sum())
    if size >= 1 or template.uncoupled:
        return None  # cells without neighbours have a closed form
    time = float(np.log((1 + template.state_bound()) / TOLERANCE) / (1 - size))
    return RunningTime(time, f"a contraction: sum|A| = {size:.3g} < 1, so errors shrink to {TOLERANCE:g}")


def _uncoupled(template: Template, boundary: Boundary, pairs: list[Pair], arbitrary: bool, step: float) -> RunningTime:
    a = template.self_feedback
    centre = sum(tap.weight for tap in template.control_taps if tap.k == tap.l == 0)
    others = [tap.weight for tap in template.control_taps if (tap.k, tap.l) != (0, 0)]
    values = {u for _, u in pairs} | {u for _, u in boundary.constants}
    sums = weighted_sums([[(weight * u,) for u in values] for weight in others])
    if sums is None:
        return RunningTime(None, too_many(len(others)))
    worst = 0.0
    for x0, u in pairs:
        s = sums[:, 0] + centre * u + template.z
        if arbitrary and a > 1 and np.abs(s).min() <= a - 1 + _TIE:
            return RunningTime(None, "the initial state decides, and it may be anything")
        worst = max(worst, float(cell_time(s, np.full_like(s, x0), a, step).max()))
    if not np.isfinite(worst):
        return RunningTime(None, "a tie: some neighbourhood drives its cell neither way")
    return RunningTime(worst, "no neighbours: the closed form, worst case over all black-and-white neighbourhoods")


def _fewer_and_fewer(pairs: list[Pair]) -> list[tuple[list[Pair], str]]:
    """Return sets of pairs (x(0), u) with the assumption of each: all pairs, then for two pictures all but one."""
    tries = [(pairs, "")]
    colour = {1.0: "black", -1.0: "white"}
    if len(pairs) == 4:
        for out in ((1.0, -1.0), (-1.0, 1.0), (1.0, 1.0), (-1.0, -1.0)):
            text = f"no cell is {colour[out[0]]} in the initial state and {colour[out[1]]} in the input"
            tries.append(([pair for pair in pairs if pair != out], text))
    return tries
