"""Steps of a program that come down to an AND or OR of neighbours in packed black-and-white planes."""

from cnnsim.network import CHUA_YANG
from cnnsim.operations.bitwise import BitRule, bit_rule
from cnnsim.program.program import Program, TemplateStep


def rule_of(program: Program, step: TemplateStep) -> BitRule | None:
    """Return the AND or OR that a step from LLM to LLM comes down to, None if it does not."""
    u, x0 = step.input, step.state
    logic = isinstance(u, str) and program.memory[u] == program.memory[step.to] == "llm"
    whole = step.bias is None and step.mask is None and step.duration == "settled" and step.cell == CHUA_YANG
    if logic and whole and (x0 == u or not isinstance(x0, str)):
        return bit_rule(step.template, step.boundary, None if isinstance(x0, str) else x0)
    return None
