"""Hard cases: one module a family. A case has its difficulty, the exact answer, a bound, and the naive form."""

from tests.hard_cases import grids, inputs, motion, templates, touch_inverse, touch_loads, touch_skin, touch_texture
from tests.hard_cases.case import HardCase

FAMILIES: dict[str, list[HardCase]] = {
    "templates": templates.CASES,
    "motion": motion.CASES,
    "grids": grids.CASES,
    "inputs": inputs.CASES,
    "inverse": touch_inverse.CASES,
    "located loads": touch_loads.CASES,
    "skin": touch_skin.CASES,
    "texture": touch_texture.CASES,
}
