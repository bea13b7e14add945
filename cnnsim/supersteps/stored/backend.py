"""Stored backend: planes lie on the disk, and each verb of a backend is done on them block by block, by workers.

A machine runs its programs on it as on any backend. What each operation made and answered is in the store before the
next one begins, so a program that was stopped goes on there.
"""

from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from cnnsim.backends.base import Backend, Memory, Outcome
from cnnsim.network import Boundary, Characteristic
from cnnsim.network.characteristic import CLIP
from cnnsim.operations.bitwise import BitRule
from cnnsim.operations.cellwise import Cellwise
from cnnsim.planning.plan import Plan
from cnnsim.supersteps.engine import Engine
from cnnsim.supersteps.large import run_linked
from cnnsim.supersteps.shards import can_be_read, create
from cnnsim.supersteps.store import zarr_library
from cnnsim.supersteps.stored.operations import Operations
from cnnsim.supersteps.stored.plane import PlaneFiles, StoredPlane
from cnnsim.supersteps.stored.task import check_finite, shards_at
from cnnsim.support import Array, Integers
from cnnsim.support.memory import check_memory
from cnnsim.support.progress import watched_by

OUTPUTS = "outputs"
"""The group of a store with what programs gave, an array for each plane, as Zarr arrays that others can read."""


class StoredBackend(Backend):
    """The backend ``where`` on planes that are `StoredPlane`, in the store of an ``engine``; ``on``: what is done."""

    def __init__(self, where: Backend, engine: Engine) -> None:
        self.name, self.dtype = where.name, where.dtype
        self.chosen_device = getattr(where, "chosen_device", None)
        self.on = Operations(where, engine)

    def load(self, values: Any, memory: Memory, *, copy: bool = True) -> StoredPlane:
        """Bring a plane in, block by block; a Zarr array that the tasks can read as it is stays where it is."""
        shape = tuple(values.shape)
        if memory == "lam" and hasattr(values, "store_path") and self._linked(values):
            path = (Path(values.store.root) / values.path).absolute()
            plane = StoredPlane(PlaneFiles(path, shape, _not_ours, path), memory)
            self.on.do(lambda _: self.on.tasks("finite", (), [plane], [], self.on.blocks(shape)) and None)
            return plane

        def work(name: str) -> None:
            self.on.create(name, shape, memory)
            blocks, files = self.on.blocks(shape), shards_at(self.on.folder / name, self.on.opened)
            told = self.on.progress.of_blocks(len(blocks))
            for block in range(len(blocks)):
                (r0, r1), (c0, c1) = area = blocks.area(block)
                files.write(area, self._values(values[..., r0:r1, c0:c1], memory))
                told(block + 1)

        return self.on.plane(self.on.do(work)[0], shape, memory)

    def _values(self, part: Any, memory: Memory) -> Array:
        values = np.asarray(part)
        check_finite(values)
        if memory == "llm":
            return values > 0
        return np.where(values, 1, -1).astype(self.dtype) if values.dtype == bool else values.astype(self.dtype)

    def _linked(self, values: Any) -> bool:
        return "=" not in self.on.engine.name and can_be_read(values, self.dtype) and not values.attrs.get("bits")

    def constant(self, value: float | Array, shape: tuple[int, ...], memory: Memory) -> StoredPlane:
        """Make a plane of one number: an array without a file."""
        if isinstance(value, np.ndarray):  # one for each grid of a batch
            return self.load(np.broadcast_to(value, shape), memory)
        return self.on.plane(self.on.do(lambda name: self.on.create(name, shape, memory, value))[0], shape, memory)

    def read(self, plane: StoredPlane, *, copy: bool = True) -> Array:
        """Bring a whole plane out.

        Raises:
            InputError: there is no memory for it.
        """
        dtype = np.dtype(bool) if plane.memory == "llm" else self.dtype
        size = plane.shape[0] if len(plane.shape) == 3 else 1
        rows, cols = plane.shape[-2:]
        check_memory("a whole plane", size * rows * cols * dtype.itemsize, "Zarr arrays as inputs, and a store, wanted")
        return shards_at(plane.files.path, self.on.opened).cells(np.arange(rows), np.arange(cols), dtype)

    def hand_out(self, name: str, plane: StoredPlane) -> Any:
        """Write a result among the store's outputs and return it: a Zarr array where results stay, else an array."""
        path = self.on.folder / OUTPUTS / (name if self.on.runs == 1 else f"{name}-{self.on.runs}")

        def work(_: str) -> None:
            dtype = bool if plane.memory == "llm" else self.dtype
            outputs = self.on.group.require_group(OUTPUTS)
            create(outputs, path.name, plane.shape, dtype, self.on.journal.record.side)
            self.on.tasks("copy", (), [plane], [path], self.on.blocks(plane.shape))

        self.on.do(work)
        if self.on.stays:
            return zarr_library().open_array(path, mode="r")
        return self.read(StoredPlane(PlaneFiles(path, plane.shape, _not_ours, path), plane.memory))

    def convert(self, plane: StoredPlane, memory: Memory) -> StoredPlane:
        """See `Backend.convert`; black and white as numbers is read so from the bits."""
        if memory == "lam" or plane.memory == memory:
            return plane._replace(memory=memory)
        return self.on.made("convert", (memory,), [plane], memory)[0]

    def transient(
        self, plan: Plan, x: StoredPlane, u: StoredPlane | None, bias: StoredPlane | None = None,
        mask: StoredPlane | None = None,
    ) -> Outcome:  # fmt: skip
        """Run a transient in supersteps (see `cnnsim.supersteps.run`), in a store of its own beside the planes."""
        named = {"state": x, "input": u, "bias": bias, "mask": mask}
        linked = {name: str(plane.files.path.absolute()) for name, plane in named.items() if plane is not None}

        def work(name: str) -> list[Any]:
            with watched_by(self.on.progress.of_supersteps()):
                end, saturated = run_linked(
                    plan, linked, x.shape, self.on.place, self.on.engine, self.on.journal.record.side,
                    self.on.folder / name, self.on.workers, f"{self.on.journal.run} {name}",
                )  # fmt: skip
            return [*(end[key] for key in ("plane", "t", "settled", "rate")), saturated]

        name, (plane, t, settled, rate, saturated) = self.on.do(work)
        end = self.on.plane(f"{name}/{plane}", x.shape, "lam", name)
        return Outcome(end, float(t), bool(settled), float(rate), bool(saturated))

    def seen(self, outcome: Outcome, see: Callable[[], tuple[Outcome, Any]]) -> Outcome:
        """Return what is seen of an outcome, whose plane may be read as a whole for it; looked at once."""
        found: list[Outcome] = []

        def work(_: str) -> list[Any]:
            with self.on.journal.inside():
                found.append(see()[0])
            after = found[0]
            place = "" if after.x is outcome.x else str(after.x.files.path.relative_to(self.on.folder))
            return [place, after.t, after.settled, after.rate]

        _, (place, t, settled, rate) = self.on.do(work)
        if found:
            return found[0]
        x = self.on.plane(place, outcome.x.shape, "lam", place.split("/")[0]) if place else outcome.x
        return outcome._replace(x=x, t=float(t), settled=bool(settled), rate=float(rate))

    def output(self, x: StoredPlane, f: Characteristic = CLIP) -> StoredPlane:
        """See `Backend.output`."""
        return self.on.made("output", (f,), [x], "lam")[0]

    def cellwise(
        self, operation: Cellwise, planes: Sequence[StoredPlane], parameters: Sequence[float]
    ) -> tuple[StoredPlane, ...]:
        """See `Backend.cellwise`."""
        return self.on.made("cellwise", (operation.name, *parameters), planes, *_lams(operation))

    def logic(self, function: int, p: StoredPlane, q: StoredPlane) -> StoredPlane:
        """See `Backend.logic`."""
        return self.on.made("logic", (function,), [p, q], "llm")[0]

    def neighbourhood(self, rule: BitRule, boundary: Boundary, plane: StoredPlane) -> StoredPlane:
        """See `Backend.neighbourhood`."""
        return self.on.made("neighbourhood", (rule, boundary), [plane], "llm", boundary=boundary, halo=rule.radius)[0]

    def count(self, plane: StoredPlane) -> int | Integers:
        """See `Backend.count`: the sum of what the blocks count."""

        def work(_: str) -> Any:
            numbers = self.on.tasks("count", (), [plane], [], self.on.blocks(plane.shape))
            return np.sum(np.array(numbers, np.int64), axis=0).tolist()

        answer = self.on.do(work)[1]
        return np.array(answer, np.int64) if isinstance(answer, list) else int(answer)


def _lams(operation: Cellwise) -> tuple[Memory, ...]:
    lam: Memory = "lam"
    return (lam,) * len(operation.outputs)


def _not_ours(_: Path) -> None:
    """Leave an array alone that is somebody's own, or a result."""
