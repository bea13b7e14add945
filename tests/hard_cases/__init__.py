"""Hard cases: one module a family, each case with why it is hard, the exact answer, a bound, and the naive form."""

from tests.hard_cases import grids, inputs, templates
from tests.hard_cases.case import HardCase

FAMILIES: dict[str, list[HardCase]] = {
    "templates": templates.CASES,
    "grids": grids.CASES,
    "inputs": inputs.CASES,
}
