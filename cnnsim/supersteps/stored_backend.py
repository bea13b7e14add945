"""Stored backend: the verbs of a backend on planes that are Zarr arrays, computed block by block by workers.

Operations are numbered in their order, and the store records how many are done, and their answers. A program takes the
same path from the same answers, so a stopped program runs again from its start, skips the operations that are done, and
resumes with the next one.
"""

from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from shutil import rmtree
from tempfile import mkdtemp
from typing import Any
from weakref import finalize

import numpy as np

from cnnsim.backends.base import Backend, Memory, Outcome
from cnnsim.network import ZERO_FLUX, Boundary, Characteristic
from cnnsim.network.characteristic import CLIP
from cnnsim.operations.bitwise import BitRule
from cnnsim.operations.cellwise import Cellwise
from cnnsim.planning.plan import Plan
from cnnsim.supersteps.block_task import STATE, Place
from cnnsim.supersteps.blocks import Blocks
from cnnsim.supersteps.engine import Engine, check_worker_memory, side_of_blocks
from cnnsim.supersteps.plane_task import PlaneTask, run_plane_task
from cnnsim.supersteps.run import STATES, Record, Supersteps
from cnnsim.supersteps.store import GridStore, zarr_library
from cnnsim.support import Array, InputError, Integers
from cnnsim.support.memory import check_memory
from cnnsim.support.progress import watcher
from cnnsim.workers import Workers, open_workers

KIND = "cnnsim program"


class StoredPlane:
    """A plane of a program as a Zarr array; ``dropped`` is called with its folder when the plane is garbage."""

    def __init__(
        self, path: Path, shape: tuple[int, ...], memory: Memory, dropped: Callable[[Path], None], folder: Path
    ) -> None:
        self.path, self.shape, self.memory = path, shape, memory
        finalize(self, dropped, folder).atexit = False  # a stopped program resumes with its planes


class StoredBackend(Backend):
    """The backend ``where``, run block by block on planes in the store of an ``engine``.

    ``step`` names the present step of the program in messages.
    """

    def __init__(self, where: Backend, engine: Engine) -> None:
        self.name, self.dtype, self.step = where.name, where.dtype, ""
        self.chosen_device = getattr(where, "chosen_device", None)
        self._place, self._engine = Place(where.name, where.dtype.str, self.chosen_device), engine
        self._folder = (engine.store or Path(mkdtemp(prefix="cnnsim-store-"))).absolute()
        if engine.store is None:
            finalize(self, rmtree, self._folder, ignore_errors=True)
        self._number = self._runs = 0
        self._unused: list[Path] = []
        self._stays = False
        self._workers: Workers
        self._store: GridStore
        self._record: dict[str, Any]

    @contextmanager
    def running(self, run: str, shape: tuple[int, ...], *, stays: bool) -> Iterator[None]:
        """Run a program in a block with the identity ``run``; ``stays``: its results are Zarr arrays of the store.

        Raises:
            InputError: the store is of another program or of other planes; an operation fails.
        """
        self._stays = stays and self._engine.store is not None
        with open_workers(self._engine.name, self._engine.workers) as self._workers:
            if not self._runs:
                self._store = GridStore(self._folder, run, KIND)
                side = side_of_blocks(self._engine, shape, self._workers.count)
                self._record = self._store.record or {"side": side, "done": 0, "answers": {}}
                self._engine.side_of_store(self._folder, self._record["side"])
            self._runs += 1
            if self._do(lambda _: run)[1] != run:
                raise InputError(
                    f"run {self._runs} in {self._folder} had other planes; the same planes, or another folder, wanted"
                )
            try:
                yield
            except (InputError, OSError) as error:
                what = (error.strerror if isinstance(error, OSError) else None) or str(error)
                kept = f"; {self._engine.store} keeps the operations before: run again to resume"
                raise InputError(what + (kept if self._engine.store else "")) from error
            self._delete_unused()

    def _do(self, work: Callable[[str], Any]) -> tuple[str, Any]:
        """Return the name of the next operation and its answer, recorded or computed now."""
        self._number += 1
        name, record = f"{self._number:06d}", self._record
        if self._number > record["done"]:
            self._delete_unused()
            answer = work(name)
            if answer is not None:
                record["answers"][name] = answer
            record["done"] = self._number
            self._store.commit(record)
        return name, record["answers"].get(name)

    def _delete_unused(self) -> None:
        """Delete planes without a reference: no operation to come needs them."""
        while self._unused:
            rmtree(self._unused.pop(), ignore_errors=True)

    def _plane(self, name: str, shape: tuple[int, ...], memory: Memory, folder: str = "") -> StoredPlane:
        return StoredPlane(self._folder / name, shape, memory, self._unused.append, self._folder / (folder or name))

    def _create(self, name: str, shape: tuple[int, ...], memory: Memory, fill: float = 0) -> Path:
        dtype, value = (bool, fill > 0) if memory == "llm" else (self.dtype, fill)
        self._store.create(name, shape, dtype, self._record["side"], value)
        return self._folder / name

    def _blocks(self, shape: tuple[int, ...], boundary: Boundary = ZERO_FLUX) -> Blocks:
        return Blocks((shape[-2], shape[-1]), self._record["side"], boundary)

    def _tasks(
        self, verb: str, arguments: tuple[Any, ...], takes: Sequence[StoredPlane], gives: Sequence[Path],
        boundary: Boundary = ZERO_FLUX, halo: int = 0,
    ) -> list[Any]:  # fmt: skip
        """Run an operation on all blocks and return its numbers."""
        blocks = self._blocks(takes[0].shape, boundary)
        taken = tuple((plane.path, plane.memory) for plane in takes)
        tasks = [
            PlaneTask(blocks, self._place, block, halo, verb, arguments, taken, tuple(gives))
            for block in range(len(blocks))
        ]
        numbers = []
        for number in self._workers.map(run_plane_task, tasks):
            numbers.append(number)
            if (report := watcher()) is not None:
                report(None, f"{self.step}: {len(numbers)} of {len(blocks)} blocks")
        return numbers

    def _made(
        self, verb: str, arguments: tuple[Any, ...], takes: Sequence[StoredPlane], *memories: Memory,
        boundary: Boundary = ZERO_FLUX, halo: int = 0,
    ) -> tuple[StoredPlane, ...]:  # fmt: skip
        """Run an operation that makes planes, in these memories."""
        shape = takes[0].shape

        def work(name: str) -> None:
            gives = [self._create(f"{name}.{number}", shape, memory) for number, memory in enumerate(memories)]
            self._tasks(verb, arguments, takes, gives, boundary, halo)

        name, _ = self._do(work)
        return tuple(self._plane(f"{name}.{number}", shape, memory) for number, memory in enumerate(memories))

    def load(self, values: Any, memory: Memory, *, copy: bool = True) -> StoredPlane:
        """See `Backend.load`; also of Zarr arrays, block by block."""
        shape, logic = tuple(values.shape), memory == "llm"

        def work(name: str) -> None:
            self._store.write_plane(name, values, shape, self.dtype, self._blocks(shape), logic=logic)

        return self._plane(self._do(work)[0], shape, memory)

    def constant(self, value: float | Array, shape: tuple[int, ...], memory: Memory) -> StoredPlane:
        """See `Backend.constant`: an array without chunks, of its fill value."""
        if isinstance(value, np.ndarray):  # one number for each grid of a batch
            return self.load(np.broadcast_to(value, shape), memory)
        return self._plane(self._do(lambda name: self._create(name, shape, memory, value) and None)[0], shape, memory)

    def read(self, plane: StoredPlane, *, copy: bool = True) -> Array:
        """See `Backend.read`.

        Raises:
            InputError: the plane does not fit in memory.
        """
        array = zarr_library().open_array(plane.path, mode="r")
        check_memory("a whole plane", array.nbytes, "Zarr arrays as inputs, and a store, wanted")
        return np.asarray(array[...])

    def hand_out(self, name: str, plane: StoredPlane) -> Any:
        """Copy a result to the array "outputs/name" and return it, as a Zarr array if results stay in the store."""
        target = f"outputs/{name if self._runs == 1 else f'{name}-{self._runs}'}"
        self._do(lambda _: self._tasks("copy", (), [plane], [self._create(target, plane.shape, plane.memory)]) and None)
        found = zarr_library().open_array(self._folder / target, mode="r")
        check_memory("the result", 0 if self._stays else found.nbytes, "Zarr arrays as inputs, and a store, wanted")
        return found if self._stays else np.asarray(found[...])

    def convert(self, plane: StoredPlane, memory: Memory) -> StoredPlane:
        """See `Backend.convert`."""
        return plane if plane.memory == memory else self._made("convert", (memory,), [plane], memory)[0]

    def transient(
        self, plan: Plan, x: StoredPlane, u: StoredPlane | None, bias: StoredPlane | None = None,
        mask: StoredPlane | None = None,
    ) -> Outcome:  # fmt: skip
        """See `Backend.transient`: in supersteps, in a store of its own inside the store."""
        named = {STATE: x, "input": u, "bias": bias, "mask": mask}
        planes = {name: plane.path for name, plane in named.items() if plane is not None}

        def work(name: str) -> list[Any]:
            store, side, engine = GridStore(self._folder / name, name, KIND), self._record["side"], self._engine
            record = Record(side) if store.record is None else Record(**store.record)
            check_worker_memory(engine, plan, side, x.shape, self.dtype, set(planes), self.name, self._workers.count)
            steps = Supersteps(plan, store, record, planes, self._place, engine, self._workers)
            steps.run()
            for other in set(STATES) - {steps.state.name}:
                rmtree(store.folder / other, ignore_errors=True)
            return [steps.state.name, steps.time, record.settled, record.rate, record.saturated]

        name, (state, t, settled, rate, saturated) = self._do(work)
        return Outcome(self._plane(f"{name}/{state}", x.shape, "lam", name), t, settled, rate, saturated)

    def seen(self, outcome: Outcome, see: Callable[[], tuple[Outcome, Any]]) -> Outcome:
        """Return the outcome that ``see`` makes of one: recorded, as it may read planes that are deleted later."""
        key = f"end of {self._number}"
        if key not in self._record["answers"]:
            after = see()[0]
            self._record["answers"][key] = [after.x is not outcome.x, after.t, after.settled, after.rate]
            self._store.commit(self._record)
            return after
        loaded, t, settled, rate = self._record["answers"][key]
        x = self._plane(self._do(lambda _: None)[0], outcome.x.shape, "lam") if loaded else outcome.x
        return Outcome(x, t, settled, rate, outcome.saturated)

    def output(self, x: StoredPlane, f: Characteristic = CLIP) -> StoredPlane:
        """See `Backend.output`."""
        return self._made("output", (f,), [x], "lam")[0]

    def cellwise(
        self, operation: Cellwise, planes: Sequence[StoredPlane], parameters: Sequence[float]
    ) -> tuple[StoredPlane, ...]:
        """See `Backend.cellwise`."""
        memories: list[Memory] = ["lam"] * len(operation.outputs)
        return self._made("cellwise", (operation.name, *parameters), planes, *memories)

    def logic(self, function: int, p: StoredPlane, q: StoredPlane) -> StoredPlane:
        """See `Backend.logic`."""
        return self._made("logic", (function,), [p, q], "llm")[0]

    def neighbourhood(self, rule: BitRule, boundary: Boundary, plane: StoredPlane) -> StoredPlane:
        """See `Backend.neighbourhood`."""
        return self._made("neighbourhood", (rule, boundary), [plane], "llm", boundary=boundary, halo=rule.radius)[0]

    def count(self, plane: StoredPlane) -> int | Integers:
        """See `Backend.count`: the sum over the blocks."""
        answer = self._do(lambda _: np.sum(np.array(self._tasks("count", (), [plane], []), np.int64), axis=0).tolist())[
            1
        ]
        return np.array(answer, np.int64) if isinstance(answer, list) else int(answer)
