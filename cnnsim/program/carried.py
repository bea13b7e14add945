"""Kept planes as they go to another process and come from one: arrays, and programs that are told by what they hold."""

from collections.abc import Mapping
from typing import Any, NamedTuple

from cnnsim.backends.base import Backend, Memory, Plane
from cnnsim.program.program import Program
from cnnsim.support import Array


class Kept(NamedTuple):
    """The planes that a program kept of its last run, and their shape."""

    shape: tuple[int, ...]
    planes: dict[str, Plane]


Carried = list[tuple[Program, tuple[int, ...], dict[str, tuple[Array, Memory]]]]
"""Programs with what they keep, no plane of it on a device."""


def packed(kept: Mapping[Program, Kept], backend: Backend) -> Carried:
    """Return the planes that are kept on a backend, read from it."""
    return [
        (program, shape, {name: (backend.read(plane), program.memory[name]) for name, plane in planes.items()})  # type: ignore[misc]  # registers are not kept
        for program, (shape, planes) in kept.items()
    ]


def unpacked(carried: Carried, backend: Backend) -> dict[Program, Kept]:
    """Return them on a backend."""
    return {
        program: Kept(shape, {name: backend.load(array, memory) for name, (array, memory) in planes.items()})
        for program, shape, planes in carried
    }


def same_program(programs: Any, program: Program) -> Program | None:
    """Return which of some programs is the same as one by what it does: a program that was copied is another object."""
    from cnnsim.supersteps.identity import signature  # only where a machine was copied

    def told(one: Program) -> str:
        return signature((one.memory, one.inputs, one.outputs, one.keep, one.steps), {})

    return next((one for one in programs if told(one) == told(program)), None)
