"""UniversalMachine runs analogic programs on one backend and keeps their planes; run_program runs one once."""

from __future__ import annotations

import math
from difflib import get_close_matches
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple, NoReturn

from numpy.typing import ArrayLike

from cnnsim import backends
from cnnsim.backends.base import Backend, Plane
from cnnsim.program.block_cache import BlockCache, TemplateCache
from cnnsim.program.execution import Execution, filled
from cnnsim.program.file import load_program
from cnnsim.program.inputs import check_inputs, check_planes_fit, check_values, parameters_meant
from cnnsim.program.outputs import ProgramOutputs
from cnnsim.program.program import Program
from cnnsim.support import Array, InputError
from cnnsim.support.keywords import spelled, unknown_keyword
from cnnsim.support.memory import LARGE
from cnnsim.support.values import is_whole
from cnnsim.task import Dtype

if TYPE_CHECKING:
    from cnnsim.supersteps.engine import Engine


class Kept(NamedTuple):
    """The planes that a program kept of its last run, and their shape."""

    shape: tuple[int, ...]
    planes: dict[str, Plane]


class UniversalMachine:
    """A cellular neural network with memories, a logic unit and a program store, on one backend.

    Planes stay on the backend while a program runs. What a program keeps (see `Program`) lives here from run to run;
    `reset` forgets it. Arguments: ``backend`` a name or a backend; ``dtype`` the numbers it computes with, None for its
    own; ``threads`` of the cpu backend, None for as many as pay; ``engine`` and ``store`` as in `run_transient`: planes
    then lie on the disk in blocks, and a machine that was stopped goes on when it runs the same programs again. Roska
    and Chua, "The CNN universal machine", IEEE Trans. CAS-II 40 (1993) 163.
    """

    @spelled()
    def __init__(
        self, backend: str | Backend = "cpu", dtype: Dtype | None = None, *, threads: int | None = None,
        engine: str | Engine | None = None, store: str | Path | None = None,
    ) -> None:  # fmt: skip
        self.backend = backends.chosen(backend, dtype, threads)
        self._kept: dict[Program, Kept] = {}
        templates, self._on_engine = TemplateCache(), None
        if engine is not None or store is not None:
            from cnnsim.program.on_engine import OnEngine  # only here: it brings processes and Zarr

            self._on_engine = OnEngine(self.backend, engine or "processes", store, templates)
            self.backend = self._on_engine.backend
        self._blocks = BlockCache(self.backend, templates)

    def __repr__(self) -> str:
        """The backend, and the names of the programs that keep planes."""
        kept = ", ".join(program.name for program in self._kept)
        return f"UniversalMachine({self.backend.name}, {self.backend.dtype}{f', planes of {kept}' if kept else ''})"

    def __reduce__(self) -> NoReturn:
        """Refuse to be copied: planes stay with their backend."""
        raise TypeError("a UniversalMachine cannot be pickled or copied; one made in each process wanted")

    def reset(self) -> None:
        """Forget all kept planes."""
        self._kept.clear()

    def kept(self, program: Program) -> dict[str, Array]:
        """Return the planes that a program kept in its last run: floats from a LAM, booleans from an LLM.

        Raises:
            InputError: no program.
        """
        _check_program(program)
        kept = self._kept.get(program)
        return {} if kept is None else {name: self.backend.read(plane) for name, plane in kept.planes.items()}

    def prepare(self, program: Program, shape: tuple[int, ...]) -> None:
        """Plan and compile a program's steps for planes of this shape, so that its first run is fast.

        Raises:
            InputError: no program, or no shape of planes.
        """
        _check_program(program)
        if not (isinstance(shape, tuple) and len(shape) in (2, 3) and all(is_whole(n) and n >= 1 for n in shape)):
            raise InputError(f"shape {shape!r}; (rows, cols) or (n, rows, cols) wanted")
        self._blocks.prepare(program, shape)

    def run(self, program: Program, **inputs: ArrayLike) -> dict[str, Any]:
        """Run a program on planes (rows, cols) of one shape and return its outputs: arrays, and numbers from wires.

        Planes (n, rows, cols) are n independent grids; wires then give (n,) numbers, and steps that
        ask a wire what to do are errors.

        Raises:
            InputError: an input is missing, unknown or of another shape; a step fails (the message names it).
        """
        _check_program(program)
        arrays = check_inputs(program, inputs, stored=self._on_engine is not None)
        if self._on_engine is not None:
            with self._on_engine.running(program, arrays):
                return self._run(program, arrays)
        shape = next(iter(arrays.values())).shape
        if math.prod(shape) >= LARGE:
            check_planes_fit(program, shape, self.backend.dtype.itemsize)
        return self._run(program, arrays)

    def _run(self, program: Program, arrays: dict[str, Array]) -> dict[str, Any]:
        backend, shape = self.backend, next(iter(arrays.values())).shape
        planes: dict[str, Any] = {
            name: backend.load(array, program.memory[name])  # type: ignore[arg-type]  # inputs are never wires
            for name, array in arrays.items()
        }
        if program.keep:
            kept = self._kept.get(program)
            if kept is not None and kept.shape == shape:
                planes.update(kept.planes)
            else:
                planes.update({name: filled(backend, program, name, v, shape) for name, v in program.keep.items()})
        Execution(self._blocks, program, planes, shape, self._on_engine).run(program.steps)
        if program.keep:
            self._kept[program] = Kept(shape, {name: planes[name] for name in program.keep})
        return {
            name: planes[name] if program.memory[name] == "wire" else backend.hand_out(name, planes[name])
            for name in program.outputs
        }


def _check_program(program: object) -> None:
    if not isinstance(program, Program):
        raise InputError(f"program {program!r}; a Program, as of load_program, wanted")


def run_program(
    program: Program | str | Path, /, *, backend: str | Backend = "cpu", dtype: Dtype | None = None,
    threads: int | None = None, engine: str | Engine | None = None, store: str | Path | None = None,
    **planes: ArrayLike,
) -> ProgramOutputs:  # fmt: skip
    """Run a program once and return its outputs: arrays (rows, cols), logic planes as booleans; numbers from wires.

    Arguments: ``program`` a name of the library, a file or a loaded `Program`; ``planes`` its inputs (rows, cols) by
    name; ``backend`` a name or a backend; ``dtype`` the numbers it computes with, None for its own;
    ``threads`` of the cpu backend, None for as many as pay; ``engine`` for grids that are larger than the memory, or
    for other machines: "processes", "dask=ADDRESS" or an `Engine`, with the folder of its ``store``, from which
    a stopped run resumes. Planes may be Zarr arrays then; with a store the results are Zarr arrays too.
    Planes under ``keep`` have their initial value in each call; a `UniversalMachine` keeps them between runs.

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
    return ProgramOutputs(machine.run(loaded, **planes))
