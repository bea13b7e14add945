"""Programs of the library on the page's picture: every step with the plane or the number that it writes."""

from typing import TYPE_CHECKING, Any

import numpy as np

from cnnsim import backends
from cnnsim.library.folders import programs
from cnnsim.program.block_cache import BlockCache, TemplateCache
from cnnsim.program.execution import Execution, filled
from cnnsim.program.file import load_program
from cnnsim.program.inputs import check_inputs
from cnnsim.program.numbering import numbered
from cnnsim.program.program import Program, Step, TemplateStep
from cnnsim.studio.colours import indices
from cnnsim.studio.message import Message
from cnnsim.support import Array, InputError

if TYPE_CHECKING:
    from cnnsim.studio.session import Session

MOST_SHOWN = 60
"""Steps of a strip; a loop does more, and its first ones are shown."""
_SIDE = 96
"""Pixels of the longer side of a picture of the strip, at most."""


class WatchedExecution(Execution):
    """An execution step by step that keeps what the first steps write."""

    def __init__(self, blocks: BlockCache, program: Program, planes: dict[str, Any], shape: tuple[int, ...]) -> None:
        super().__init__(blocks, program, planes, shape)
        self.numbers = {id(step): number for number, step in numbered(program.steps)}
        self.done: list[tuple[str, Step, str, Any]] = []
        self.steps = 0

    def run(self, steps: tuple[Step, ...]) -> None:
        """Run steps one by one."""
        for step in steps:
            self._step(step)
            to = getattr(step, "to", "")
            for name in (to,) if isinstance(to, str) else to:
                self.steps += bool(name)
                if name and len(self.done) < MOST_SHOWN:
                    self.done.append((self.numbers[id(step)], step, name, self.planes[name]))


def run_watched(program: Program, picture: Array) -> tuple[WatchedExecution, dict[str, Any]]:
    """Run a program with a picture for every input; return the execution and the planes by name.

    Raises:
        InputError: as `UniversalMachine.run`.
    """
    backend = backends.get()
    blocks = BlockCache(backend, TemplateCache())
    arrays = check_inputs(program, dict.fromkeys(program.inputs, picture))
    planes: dict[str, Any] = {
        name: backend.load(array, program.memory[name])  # type: ignore[arg-type]  # inputs are never wires
        for name, array in arrays.items()
    }
    shape = picture.shape
    planes |= {name: filled(backend, program, name, value, shape) for name, value in program.keep.items()}
    execution = WatchedExecution(blocks, program, planes, shape)
    execution.run(program.steps)
    return execution, planes


def _programs(_session: "Session", _message: Message) -> Message:
    rows = []
    for name in programs():
        try:
            program = load_program(name)
        except InputError:  # `cnnsim list` reports a broken file
            continue
        rows.append({"name": name, "summary": program.summary, "inputs": program.inputs})
    return Message({"is": "programs", "found": rows})


def _program(session: "Session", message: Message) -> Message:
    """Run a program and reply with its strip; wires are numbers."""
    program = load_program(message.text("name")) if message.text("name") in programs() else None
    if program is None:
        raise InputError(f"no program {message.text('name')!r} in the library")
    picture = session.setup.picture[0] if session.setup.picture.ndim == 3 else session.setup.picture
    execution, planes = run_watched(program, picture)
    backend, every = backends.get(), max(1, -(-max(picture.shape) // _SIDE))
    steps: list[dict[str, Any]] = []
    data: list[bytes] = []
    given = [("input", None, name, planes[name]) for name in program.inputs]
    for number, step, name, value in [*given, *execution.done]:
        row: dict[str, Any] = {"number": number, "does": str(step or "the page's picture"), "to": name}
        if isinstance(step, TemplateStep) and step.name:
            row["template"] = step.name
        if program.memory[name] == "wire":
            row["value"] = int(value)
        else:
            shown = backend.read(value)[::every, ::every]
            row["plane"], row["shape"] = len(data), shown.shape
            data.append(indices(np.where(shown, 1.0, -1.0) if shown.dtype == bool else shown).tobytes())
        steps.append(row)
    outputs = {name: int(planes[name]) for name in program.outputs if program.memory[name] == "wire"}
    content = {"is": "program", "name": program.name, "summary": program.summary, "steps": steps,
               "ran": execution.steps, "shown": len(execution.done), "numbers": outputs}  # fmt: skip
    return Message(content, data)


HANDLERS = {"programs": _programs, "program": _program}
