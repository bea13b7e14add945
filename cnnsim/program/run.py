"""run_program: an analogic program in one call, on a machine of its own."""

from difflib import get_close_matches
from pathlib import Path
from typing import Any

from numpy.typing import ArrayLike

from cnnsim.backends.base import Backend
from cnnsim.keywords import unknown_keyword
from cnnsim.program.file import load_program
from cnnsim.program.inputs import check_values
from cnnsim.program.machine import UniversalMachine
from cnnsim.program.program import Program
from cnnsim.support import InputError
from cnnsim.task import Dtype


def run_program(
    program: Program | str | Path, /, *, backend: str | Backend = "cpu", dtype: Dtype | None = None,
    threads: int | None = None, **planes: ArrayLike,
) -> dict[str, Any]:  # fmt: skip
    """Run a program once and return its outputs: arrays (rows, cols), logic planes as booleans; numbers from wires.

    Arguments: ``program`` a name of the library, a file or a loaded `Program`; ``planes`` its inputs (rows, cols) by
    name; ``backend`` a name or a backend; ``dtype`` the numbers it computes with, None for its own;
    ``threads`` of the cpu backend, None for as many as pay. Planes that a
    program keeps start anew in each call; a `UniversalMachine` carries them from run to run.

    Raises:
        InputError: as `load_program`, `check_values` and `UniversalMachine.run`.
    """
    if not isinstance(program, Program | str | Path):
        raise InputError(f"program {program!r}; the name of one, a file or a Program wanted")
    loaded = program if isinstance(program, Program) else load_program(program)
    unknown = set(planes) - set(loaded.inputs)
    known = ["backend", "dtype", "threads"]
    if any(get_close_matches(name, known) for name in unknown):  # an input has a name of its own, or one of the file
        raise unknown_keyword("run_program", unknown, [*known, *loaded.inputs])
    check_values(loaded, planes)
    return UniversalMachine(backend, dtype, threads=threads).run(loaded, **planes)
