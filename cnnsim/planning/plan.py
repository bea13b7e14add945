"""Plan: the method, scheme, step and savings of a transient, chosen from its template, with the reasons."""

import math
from collections.abc import Callable, Collection, Sequence
from dataclasses import dataclass
from functools import cached_property, partial
from typing import Literal, get_args

from cnnsim.network import (
    AnyTemplate,
    Boundary,
    Cell,
    CellModel,
    Characteristic,
    LayeredTemplate,
    Tap,
    Template,
    layered,
)
from cnnsim.network.characteristic import CLIP, parse_cell
from cnnsim.network.template import all_taps
from cnnsim.planning.general import check_grid, decide_general, why_general
from cnnsim.planning.savings import Saving, halo_of_a_step, stepped_savings, steps_a_pass
from cnnsim.planning.scheme import ADAPTIVE, Scheme, find_scheme
from cnnsim.planning.stability import step_limit, turning_from, turning_of, usual_scheme
from cnnsim.planning.step import (
    DEFAULT_STEP,
    Duration,
    allowed_step,
    check_count,
    check_step,
    divided,
    usual_step,
)
from cnnsim.support import Array, InputError
from cnnsim.support.values import is_number

Method = Literal["closed form", "stepped", "adaptive", "general"]

SETTLED_RATE = 1e-4
"""A network is at rest when |dx/dt| <= this in every cell; see `Plan.duration`."""


@dataclass(frozen=True, eq=False, repr=False)
class Plan:
    """The choices for a transient: everything that a backend needs except the planes.

    ``duration`` is a number of time constants, or ``"settled"``. Settled means that either no output can change any
    more (every free cell has |x| >= 1 and sign(x) (A*y + w) >= 1, so with frozen neighbours it stays saturated), or
    the network is at rest (|dx/dt| <= 1e-4 in every free cell, and no mode that grows or keeps a constant rate). That
    is checked once a time constant, for at most ``limit`` time constants.

    ``savings`` are the savings that apply; a backend may use them and must give the same output. ``decisions`` are
    (what, why) lines for `explain`. The method "general" takes any template as a ``network`` of layers, with any
    ``characteristic``; ``template`` is then its first layer, and a missing ``scheme`` means adaptive.
    """

    template: Template
    shape: tuple[int, int]
    boundary: Boundary
    cell: CellModel
    method: Method
    duration: Duration
    limit: float
    scheme: Scheme | None
    step: float
    savings: frozenset[Saving]
    decisions: tuple[tuple[str, str], ...]
    network: LayeredTemplate | None = None
    characteristic: Characteristic = CLIP

    def __repr__(self) -> str:
        scheme = "" if self.scheme is None else f", {self.scheme.name}, h = {self.step:g}"
        return (
            f"Plan({self.template.name!r}, {self.shape[0]} x {self.shape[1]}, {self.method}{scheme}, {self.duration})"
        )

    @cached_property
    def feedback_taps(self) -> tuple[Tap, ...]:
        """The taps of A to sum: the nonzero ones, or all without the saving "sparse taps"."""
        return self.template.feedback_taps if "sparse taps" in self.savings else all_taps(self.template.A)

    def output(self, x: Array) -> Array:
        """Return the output of a state (an array); the state of discrete-time cells is their output."""
        return x if self.cell == "discrete-time" else self.characteristic(x)

    @property
    def steps(self) -> int:
        """Steps of a fixed duration, or the largest number of steps for ``"settled"``."""
        time = self.limit if self.duration == "settled" else self.duration
        return math.ceil(time / self.step - 1e-9)

    @property
    def check_every(self) -> int:
        """Steps between two checks whether the network has settled: one time constant."""
        return max(1, round(1 / self.step))

    @property
    def saturation_ends(self) -> bool:
        """Whether saturated cells whose drives point outwards stay saturated, as they do for steps of at most 1."""
        return self.cell == "chua-yang" and self.step <= 1

    @property
    def depth(self) -> int:
        """Steps in one pass over the grid, with a halo of at most `MOST_HALO` rows; 1 without blocking."""
        if "blocking" not in self.savings:
            return 1
        steps = self.check_every if self.duration == "settled" else self.steps
        assert self.scheme is not None
        return steps_a_pass(steps, halo_of_a_step(self.feedback_taps, self.scheme))

    def explain(self) -> str:
        """Return the decisions as lines of text."""
        return lines_of(self.decisions)


def lines_of(decisions: Sequence[tuple[str, str]]) -> str:
    """Return (what, why) pairs as aligned lines of text."""
    width = max(len(what) for what, _ in decisions)
    return "\n".join(f"{what:<{width}}  {why}" for what, why in decisions)


def make_plan(
    template: AnyTemplate,
    shape: tuple[int, ...],
    boundary: Boundary,
    *,
    duration: Duration = "settled",
    cell: CellModel | Cell = "chua-yang",
    scheme: str | None = None,
    step: float | None = None,
    limit: float | None = None,
    without: Collection[str] = (),
    periods: Sequence[float] = (),
    grey: Callable[[], bool] = lambda: False,
) -> Plan:
    """Decide how to run ``template`` on a grid of ``shape`` (..., rows, cols).

    ``periods`` are the holding times of planes that change with time (see `cnnsim.network.frames`). ``grey`` returns
    whether the state has cells that are not saturated; it is called only if the scheme depends on that.

    Without ``scheme`` and ``step`` the plan chooses: the closed form for uncoupled templates, else forward Euler with
    h = 0.1 or half the stability limit, whichever is less. ``without`` names savings (see `Saving`) not to use.

    Raises:
        InputError: an unstable step (the message has the limit), a negative duration or limit, an unknown name.
    """
    kind = parse_cell(cell)
    if duration != "settled" and not (is_number(duration) and 0 <= duration < math.inf):
        raise InputError(f"duration {duration!r}; 'settled' or a number of time constants >= 0 wanted")
    network = layered(template)
    grid = _grid(shape, len(network.layers))
    limit = usual_limit(grid) if limit is None else limit
    if not is_number(limit) or not 0 <= limit < math.inf:
        raise InputError(f"limit {limit!r}; a number of time constants >= 0 wanted")
    without = (without,) if isinstance(without, str) else without
    if not isinstance(without, Collection):
        raise InputError(f"without {without!r}; names of savings wanted: {', '.join(get_args(Saving))}")
    for name in without:
        if name not in get_args(Saving):
            raise InputError(
                f"without {name!r}, which is no saving; names of savings wanted: {', '.join(get_args(Saving))}"
            )
    first = network.layers[0]
    decisions = [_control_decision(first)]

    def plan(method: Method, table: Scheme | None, h: float, savings: Collection[Saving] = ()) -> Plan:
        check_count(limit if duration == "settled" else duration, h)
        return Plan(
            first, grid, boundary, kind.model, method, duration, limit, table, h, frozenset(savings), tuple(decisions),
            network if method == "general" else None, kind.output,
        )  # fmt: skip

    check_grid(network, grid)
    if why := why_general(template, kind, periods):
        table, h, decisions = decide_general(network, kind, why, scheme, step, duration, periods, grey)
        decisions.append(_stop_decision(duration, limit))
        return plan("general", table, h)
    assert isinstance(template, Template)

    if template.uncoupled and scheme is None and step is None and "closed form" not in without:
        decisions.append(("closed form", "A has only its centre, so each cell has an exact solution: no time loop"))
        return plan("closed form", None, 1.0, {"closed form"})
    if scheme == ADAPTIVE:
        if duration == "settled":
            raise InputError("the adaptive scheme runs for a number of time constants, not until settled")
        decisions.append(("adaptive", "DOP853 of scipy with relative tolerance 1e-10: a reference, not a fast method"))
        return plan("adaptive", None, 1.0)
    limit_of = partial(step_limit, template, boundary, duration)
    turning = turning_from(partial(turning_of, template, boundary, duration, allowed_step(step)), grey)
    table = (
        usual_scheme(limit_of, min(DEFAULT_STEP, allowed_step(step)), turning)
        if scheme is None
        else find_scheme(scheme)
    )
    longest = limit_of(table)
    if step is None:
        h = usual_step(table, longest, turning)
        part = "a sixth of" if table.order >= 4 else "half"
        why = "the default" if h == DEFAULT_STEP else f"{part} the stability limit {longest:.4g} of this template"
        if turning and h == 0.5 / turning:
            why = f"short enough for modes that oscillate at {turning:.3g} a time constant"
    else:
        check_step(step, longest, table, "cannot be stable")
        h, why = step, f"as requested; stable below {longest:.4g}"
    h = divided(duration, h)
    decisions += [
        (f"{table.name}, h = {h:.4g}", f"order {table.order}; the step is {why}"),
        _stop_decision(duration, limit),
    ]
    steps = max(1, round(1 / h)) if duration == "settled" else math.ceil(duration / h - 1e-9)
    applicable = stepped_savings(template, table, h, kind.model, steps, settles=duration == "settled")
    decisions += [
        (what, why) if what not in without else (f"no {what}", f"switched off: {why}") for what, why in applicable
    ]
    return plan("stepped", table, h, {what for what, _ in applicable if what not in without})


def usual_limit(grid: tuple[int, int]) -> float:
    """Return the default limit where theory gives no running time [time constants]."""
    return 200.0 + 10.0 * sum(grid)


def _grid(shape: tuple[int, ...], layers: int) -> tuple[int, int]:
    if layers > 1 and (len(shape) not in (3, 4) or shape[-3] != layers or 0 in shape):
        raise InputError(
            f"planes of shape {shape}; ({layers}, rows, cols), perhaps after an n, wanted: a plane a layer"
        )
    if (layers == 1 and len(shape) not in (2, 3)) or 0 in shape:
        raise InputError(f"planes of shape {shape}; (rows, cols) or (n, rows, cols) with at least one cell wanted")
    return shape[-2], shape[-1]


def _control_decision(template: Template) -> tuple[str, str]:
    taps = len(template.control_taps)
    if template.control_terms:
        return "B*u + z once", f"the input stands still: {'; '.join(map(str, template.control_terms))}, and {taps} taps"
    if not taps:
        return "no B*u", "B is zero: the input is not read"
    return "B*u + z once", f"the input stands still: {taps} of {template.B.size} taps, computed before the time loop"


def _stop_decision(duration: Duration, limit: float) -> tuple[str, str]:
    if duration == "settled":
        return (
            "stop when settled",
            f"no output can change, or |dx/dt| <= {SETTLED_RATE:g}; at most {limit:g} time constants",
        )
    return f"stop at t = {duration:g}", "the running time is given"
