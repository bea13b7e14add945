"""run_program: an analogic program in one call, on a machine of its own."""

from difflib import get_close_matches
from pathlib import Path
from typing import TYPE_CHECKING, Any

from numpy.typing import ArrayLike

from cnnsim.backends.base import Backend
from cnnsim.program.file import load_program
from cnnsim.program.inputs import check_values, parameters_meant
from cnnsim.program.machine import UniversalMachine
from cnnsim.program.program import Program
from cnnsim.support import InputError
from cnnsim.support.keywords import unknown_keyword
from cnnsim.task import Dtype

if TYPE_CHECKING:
    from cnnsim.supersteps.engine import Engine


def run_program(
    program: Program | str | Path, /, *, backend: str | Backend = "cpu", dtype: Dtype | None = None,
    threads: int | None = None, engine: "str | Engine | None" = None, store: str | Path | None = None,
    **planes: ArrayLike,
) -> dict[str, Any]:  # fmt: skip
    """Run a program once and return its outputs: arrays (rows, cols), logic planes as booleans; numbers from wires.

    Arguments: ``program`` a name of the library, a file or a loaded `Program`; ``planes`` its inputs (rows, cols) by
    name; ``backend`` a name or a backend; ``dtype`` the numbers it computes with, None for its own;
    ``threads`` of the cpu backend, None for as many as pay; ``engine`` for grids that are larger than the memory, or
    for other machines: "processes", "dask", "dask=ADDRESS" or an `Engine`, with the folder of its ``store``; a run
    that was stopped goes on from there. Planes may be Zarr arrays then, and with a store so are the results.
    Planes that a program keeps start anew in each call; a `UniversalMachine` carries them from run to run.

    Raises:
        InputError: as `load_program`, `check_values` and `UniversalMachine.run`.
    """
    if not isinstance(program, Program | str | Path):
        raise InputError(f"program {program!r}; the name of one, a file or a Program wanted")
    loaded = program if isinstance(program, Program) else load_program(program)
    unknown = set(planes) - set(loaded.inputs)
    known = ["backend", "dtype", "threads", "engine", "store"]
    near = any(get_close_matches(name, known) for name in unknown)
    if near and not parameters_meant(loaded, unknown):  # an input has a name of its own, or one of the file
        raise unknown_keyword("run_program", unknown, [*known, *loaded.inputs])
    check_values(loaded, planes, stored=engine is not None or store is not None)
    machine = UniversalMachine(backend, dtype, threads=threads, engine=engine, store=store)
    return machine.run(loaded, **planes)
