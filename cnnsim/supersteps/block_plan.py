"""Plan of a block: the plan of the grid for a block with its halo, and the width of that halo."""

from dataclasses import replace

from cnnsim.network import LayeredTemplate, Template, Term, reach
from cnnsim.planning.general import delays_of
from cnnsim.planning.plan import Plan
from cnnsim.support import InputError, Integers


def check_plan(plan: Plan) -> None:
    """Check that a transient can be computed block by block.

    Raises:
        InputError: delays, the adaptive scheme, a discrete-time characteristic that changes its own result.
    """
    if plan.method == "adaptive" or (plan.method == "general" and plan.scheme is None and plan.cell != "discrete-time"):
        raise InputError("the adaptive scheme needs the whole grid; a fixed-step scheme, or no engine, wanted")
    if plan.network is not None and delays_of(plan.network):
        raise InputError(f"template {plan.template.name!r} has delays; a template without, or no engine, wanted")
    f = plan.characteristic
    if plan.cell == "discrete-time" and not f.keeps_outputs:  # each superstep starts from outputs
        raise InputError(f"discrete time with the characteristic {f}; sign, or clip of slope 1, wanted")


def reach_of(plan: Plan) -> int:
    """Return the number of cells by which a change of state spreads in a step."""
    if plan.method == "closed form":
        return 0
    taps = ((tap.k, tap.l) for tap in plan.feedback_taps)
    # compiled loops read one neighbour each way, if only with weight 0: NaN in unset memory would spread from there
    radius = max(1, reach(taps)) if plan.network is None else plan.network.radius
    return radius * (1 if plan.scheme is None else len(plan.scheme.b))


def halo_of(plan: Plan, steps: int) -> int:
    """Return the width of the halo that ``steps`` steps of a block, and a check of its rate, depend on [cells]."""
    template = plan.template
    control = max(reach((tap.k, tap.l) for tap in template.control_taps), *(t.radius for t in template.terms), 0)
    return (steps + (plan.duration == "settled")) * reach_of(plan) + (plan.network.radius if plan.network else control)


def block_plan(plan: Plan, rows: Integers, cols: Integers) -> Plan:
    """Return the plan for the cells in these rows and columns, with their part of space-variant weights."""
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
