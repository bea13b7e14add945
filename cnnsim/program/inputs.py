"""Checks of a program's inputs: names, one shape, finite values, and memory."""

import math
from collections.abc import Iterable, Mapping
from difflib import get_close_matches
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from cnnsim.program.program import Program
from cnnsim.support import InputError
from cnnsim.support.memory import check_memory
from cnnsim.support.values import as_numbers, as_picture, is_stored, largest, stored_plane


def check_inputs(program: Program, inputs: dict[str, ArrayLike], *, stored: bool = False) -> dict[str, Any]:
    """Return the inputs of a run as arrays of one shape; ``stored``: those on the disk are left there.

    Raises:
        InputError: one is missing or unknown, is no array of numbers, or has another shape.
    """
    if inputs.keys() != set(program.inputs):
        unknown = [name for name in inputs if name not in program.inputs]
        near = [get_close_matches(name, program.inputs, 1) for name in unknown]
        hint = f"; did you mean {' and '.join(repr(match[0]) for match in near if match)}?" if any(near) else ""
        for name in parameters_meant(program, unknown):
            hint = f"; {name} is a parameter: load_program({program.name!r}, parameters={{{name!r}: ...}}) sets it"
        raise InputError(
            f"program {program.name!r} got {', '.join(inputs) or 'nothing'}; {', '.join(program.inputs)} wanted{hint}"
        )
    arrays: dict[str, Any] = {
        name: stored_plane(name, inputs[name])
        if stored and is_stored(inputs[name])
        else as_numbers(name, inputs[name], logic=program.memory[name] == "llm")
        for name in program.inputs
    }
    shape = next(iter(arrays.values())).shape
    if len(shape) not in (2, 3) or 0 in shape or any(array.shape != shape for array in arrays.values()):
        shapes = {name: array.shape for name, array in arrays.items()}
        raise InputError(f"program {program.name!r} got planes of shapes {shapes}; one shape (rows, cols) wanted")
    return arrays


def parameters_meant(program: Program, names: Iterable[str]) -> list[str]:
    """Return the parameters of a program that some names, which are no inputs, come near to."""
    return [match for name in names for match in get_close_matches(name, list(program.parameters), 1)]


def check_values(program: Program, inputs: Mapping[str, ArrayLike], *, stored: bool = False) -> None:
    """Refuse inputs for which a single run would give wrong results; `UniversalMachine.run` checks less, to be fast.

    Logic planes beyond [-1, 1] give a warning. ``stored``: planes on the disk are checked when they are read.

    Raises:
        InputError: an input that is not finite, or colours; several pictures where the program keeps planes from
            picture to picture: the grids of a batch are independent, so each would be a first picture.
    """
    for name in set(program.inputs) & set(inputs):
        if stored and is_stored(inputs[name]):  # looked at where it is read
            continue
        logic = program.memory[name] == "llm"
        array = as_picture(name, inputs[name], logic=True) if logic else as_numbers(name, inputs[name])
        if not np.isfinite(largest(array)):
            raise InputError(f"{name} holds {array[~np.isfinite(array)][0]}; finite numbers wanted")
        if array.ndim == 3 and program.keep:
            raise InputError(
                f"{name} has shape {array.shape}, independent grids, and program {program.name!r} "
                "keeps planes from picture to picture; a run of one UniversalMachine for each picture wanted"
            )


def check_planes_fit(program: Program, shape: tuple[int, ...], itemsize: int) -> None:
    """Refuse a grid whose planes, and those of a transient's steps, need more memory than is free."""
    kinds = list(program.memory.values())
    cell = (kinds.count("lam") + 3) * itemsize + kinds.count("llm") / 8
    cure = "a smaller grid, float32 for float64, or a machine with more memory wanted"
    check_memory(f"program {program.name!r} on {' x '.join(map(str, shape))} cells", cell * math.prod(shape), cure)
