"""Inputs of a program checked: their names, that they are planes of one shape, and that there is memory for them."""

import math
from difflib import get_close_matches

from numpy.typing import ArrayLike

from cnnsim.program.program import Program
from cnnsim.support import Array, InputError
from cnnsim.support.memory import check_memory
from cnnsim.support.values import as_numbers


def check_inputs(program: Program, inputs: dict[str, ArrayLike]) -> dict[str, Array]:
    """Return the inputs of a run as arrays of one shape.

    Raises:
        InputError: one is missing or unknown, is no array of numbers, or has another shape.
    """
    if set(inputs) != set(program.inputs):
        near = [get_close_matches(name, program.inputs, 1) for name in inputs if name not in program.inputs]
        hint = f"; did you mean {' and '.join(repr(match[0]) for match in near if match)}?" if any(near) else ""
        raise InputError(
            f"program {program.name!r} got {', '.join(inputs) or 'nothing'}; {', '.join(program.inputs)} wanted{hint}"
        )
    arrays = {name: as_numbers(name, inputs[name], logic=program.memory[name] == "llm") for name in program.inputs}
    shapes = {name: array.shape for name, array in arrays.items()}
    if len(set(shapes.values())) > 1 or any(array.ndim not in (2, 3) or not array.size for array in arrays.values()):
        raise InputError(f"program {program.name!r} got planes of shapes {shapes}; one shape (rows, cols) wanted")
    return arrays


def check_planes_fit(program: Program, shape: tuple[int, ...], itemsize: int) -> None:
    """Refuse a grid whose planes, and those of a transient's steps, need more memory than is free."""
    kinds = list(program.memory.values())
    cell = (kinds.count("lam") + 3) * itemsize + kinds.count("llm") / 8
    cure = "a smaller grid, float32 for float64, or a machine with more memory wanted"
    check_memory(f"program {program.name!r} on {' x '.join(map(str, shape))} cells", cell * math.prod(shape), cure)
