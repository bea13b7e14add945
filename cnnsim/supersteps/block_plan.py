"""Plan of a block: that of the grid for the block with its halo, and how far a step of it reaches."""

from dataclasses import replace

from cnnsim.network import LayeredTemplate, Template, Term, reach
from cnnsim.planning.general import delays_of
from cnnsim.planning.plan import Plan
from cnnsim.support import InputError, Integers

LONG = 1024
"""Steps of a known time from which blocks that sleep save more than small blocks cost."""


def check_plan(plan: Plan) -> None:
    """Refuse what cannot be cut into supersteps.

    Raises:
        InputError: delays, the adaptive scheme, a discrete-time characteristic that changes its own result.
    """
    if plan.method == "adaptive" or (plan.method == "general" and plan.scheme is None and plan.cell != "discrete-time"):
        raise InputError("the adaptive scheme looks at the whole grid; a fixed-step scheme, or no engine, wanted")
    if plan.network is not None and delays_of(plan.network):
        raise InputError(f"template {plan.template.name!r} has delays, which reach into the past; no engine wanted")
    f = plan.characteristic
    if plan.cell == "discrete-time" and not f.keeps_outputs:  # each superstep begins with outputs
        raise InputError(f"discrete time with the characteristic {f}; sign, or clip of slope 1, wanted")


def may_sleep(plan: Plan) -> bool:
    """Return whether blocks whose cells are saturated for good may be left out."""
    return plan.method == "stepped" and plan.saturation_ends


def wants_small_blocks(plan: Plan, backend: str, *, has_mask: bool) -> bool:
    """Return whether blocks are to be small, so that some of them sleep as a whole.

    Over a known time tiles sleep in a block of any size where the cpu backend takes Euler steps; elsewhere a block
    steps all that it slept through in the end, until no bit changes any more.
    """
    tiles_sleep = backend == "cpu" and not has_mask and plan.scheme is not None and len(plan.scheme.b) == 1
    return may_sleep(plan) and (plan.duration == "settled" or (not tiles_sleep and plan.steps >= LONG))


def with_sleep(plan: Plan, *, sleeps: bool) -> Plan:
    """Return the plan with tiles that may sleep in a block, whether its time is known or not; or without."""
    return replace(plan, savings=plan.savings | {"sleep"} if sleeps else plan.savings - {"sleep"})


def reach_of(plan: Plan) -> int:
    """Return how many cells a change of state travels in a step."""
    if plan.method == "closed form":
        return 0
    taps = ((tap.k, tap.l) for tap in plan.feedback_taps)
    # loops over rows look one cell around, if by a weight of 0: what is no number there would spoil the cell
    r = max(1, reach(taps)) if plan.network is None else plan.network.radius
    return r * (1 if plan.scheme is None else len(plan.scheme.b))


def halo_of(plan: Plan, steps: int, *, checked: bool) -> int:
    """Return the cells around a block that its state after so many steps, and a check of it, depend on."""
    template = plan.template
    control = max(reach((tap.k, tap.l) for tap in template.control_taps), *(t.radius for t in template.terms), 0)
    return (steps + checked) * reach_of(plan) + (plan.network.radius if plan.network else control)


def block_plan(plan: Plan, rows: Integers, cols: Integers) -> Plan:
    """Return the plan for the cells in these rows and columns; space-variant weights are those of the cells."""
    shape = len(rows), len(cols)
    if plan.network is None:
        return replace(plan, shape=shape, template=_cut(plan.template, rows, cols))
    layers = [_cut(layer, rows, cols) for layer in plan.network.layers]
    network = LayeredTemplate(layers, plan.network.time_constants, plan.network.name)
    return replace(plan, shape=shape, template=layers[0], network=network)


def _cut(template: Template, rows: Integers, cols: Integers) -> Template:
    if not any(term.weights.ndim == 4 for term in template.terms):
        return template
    terms = [_cut_term(term, rows, cols) for term in template.terms]
    return Template(template.A, template.B, template.z, template.name, terms)


def _cut_term(term: Term, rows: Integers, cols: Integers) -> Term:
    return term if term.weights.ndim == 2 else replace(term, weights=term.weights[:, :, rows[:, None], cols])
