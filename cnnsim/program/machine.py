"""UniversalMachine: analogic programs, and the planes that they keep from run to run, on one backend."""

import math
from pathlib import Path
from typing import TYPE_CHECKING, Any

from numpy.typing import ArrayLike

from cnnsim import backends
from cnnsim.backends.base import Backend
from cnnsim.program.carried import Carried, Kept, packed, same_program, unpacked
from cnnsim.program.execution import Execution, filled
from cnnsim.program.inputs import check_inputs, check_planes_fit
from cnnsim.program.parts import Parts
from cnnsim.program.program import Program
from cnnsim.program.template_steps import TemplateSteps
from cnnsim.support import Array, InputError
from cnnsim.support.keywords import spelled
from cnnsim.support.memory import LARGE
from cnnsim.support.values import is_whole
from cnnsim.task import Dtype

if TYPE_CHECKING:
    from cnnsim.supersteps.engine import Engine


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
        engine: "str | Engine | None" = None, store: str | Path | None = None,
    ) -> None:  # fmt: skip
        self.backend = backends.chosen(backend, dtype, threads)
        self._choices = self.backend, engine, store
        self._kept: dict[Program, Kept] = {}
        self._carried: dict[Program, Kept] = {}
        ways, self._on_engine = TemplateSteps(), None
        if engine is not None or store is not None:
            from cnnsim.program.on_engine import OnEngine  # only here: it brings processes and Zarr

            self._on_engine = OnEngine(self.backend, engine or "processes", store, ways)
            self.backend = self._on_engine.backend
        self._parts = Parts(self.backend, ways)

    def __repr__(self) -> str:
        """The backend, and the names of the programs that keep planes."""
        kept = ", ".join(program.name for program in (*self._carried, *self._kept))
        return f"UniversalMachine({self.backend.name}, {self.backend.dtype}{f', planes of {kept}' if kept else ''})"

    def __reduce__(self) -> Any:
        """Go to another process as the choices that were made, and the planes that programs keep."""
        if self._on_engine is not None and self._kept:
            kept = ", ".join(program.name for program in self._kept)
            raise InputError(
                f"a machine on an engine keeps planes of {kept} on the disk, which stay with its process; "
                "a machine made there with another store, or one without an engine, wanted"
            )
        return _machine, (*self._choices, packed({**self._carried, **self._kept}, self.backend))

    def reset(self) -> None:
        """Forget all kept planes."""
        self._kept.clear()
        self._carried.clear()

    def _kept_by(self, program: Program) -> Kept | None:
        if self._carried and program not in self._kept:
            carried = program if program in self._carried else same_program(self._carried, program)
            if carried is not None:
                self._kept[program] = self._carried.pop(carried)
        return self._kept.get(program)

    def kept(self, program: Program) -> dict[str, Array]:
        """Return the planes that a program kept in its last run: floats from a LAM, booleans from an LLM.

        Raises:
            InputError: no program.
        """
        _check_program(program)
        kept = self._kept_by(program)
        return {} if kept is None else {name: self.backend.read(plane) for name, plane in kept.planes.items()}

    def prepare(self, program: Program, shape: tuple[int, ...]) -> None:
        """Find out now how a program's steps are done on planes of this shape, so that its first run need not.

        Raises:
            InputError: no program, or no shape of planes.
        """
        _check_program(program)
        if not (isinstance(shape, tuple) and len(shape) in (2, 3) and all(is_whole(n) and n >= 1 for n in shape)):
            raise InputError(f"shape {shape!r}; (rows, cols) or (n, rows, cols) wanted")
        self._parts.prepare(program, shape)

    def run(self, program: Program, **inputs: ArrayLike) -> dict[str, Any]:
        """Run a program on planes (rows, cols) of one shape and return its outputs: arrays, and numbers from wires.

        Planes (n, rows, cols) are n grids that know nothing of each other; wires then give (n,) numbers, and steps that
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
            kept = self._kept_by(program)
            if kept is not None and kept.shape == shape:
                planes.update(kept.planes)
            else:
                planes.update({name: filled(backend, program, name, v, shape) for name, v in program.keep.items()})
        Execution(self._parts, program, planes, shape, self._on_engine).run(program.steps)
        if program.keep:
            self._kept[program] = Kept(shape, {name: planes[name] for name in program.keep})
        return {
            name: planes[name] if program.memory[name] == "wire" else backend.hand_out(name, planes[name])
            for name in program.outputs
        }


def _check_program(program: object) -> None:
    if not isinstance(program, Program):
        raise InputError(f"program {program!r}; a Program, as of load_program, wanted")


def _machine(
    backend: Backend, engine: "str | Engine | None", store: str | Path | None, carried: Carried
) -> UniversalMachine:
    machine = UniversalMachine(backend, engine=engine, store=store)
    machine._carried.update(unpacked(carried, machine.backend))
    return machine
