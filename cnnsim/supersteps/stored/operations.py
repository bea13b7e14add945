"""Operations on planes that lie on the disk: done block by block by workers, one after the other, each of them once."""

from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path
from shutil import rmtree
from tempfile import mkdtemp
from typing import Any
from uuid import uuid4
from weakref import finalize

from cnnsim.backends.base import Backend, Memory
from cnnsim.network import ZERO_FLUX, Boundary
from cnnsim.supersteps.block_task import Place
from cnnsim.supersteps.blocks import Blocks
from cnnsim.supersteps.engine import Engine, side_of_blocks
from cnnsim.supersteps.shards import create
from cnnsim.supersteps.store import open_store, record_of, zarr_library
from cnnsim.supersteps.stored.journal import PROGRAM, Journal, ProgramRecord
from cnnsim.supersteps.stored.plane import PlaneFiles, StoredPlane
from cnnsim.supersteps.stored.progress import ProgramProgress
from cnnsim.supersteps.stored.task import PlaneTask, run_plane_task
from cnnsim.supersteps.tasks import all_done
from cnnsim.support import InputError
from cnnsim.workers import Workers, open_workers


class Operations:
    """What a program does on the planes in the store of an ``engine``, with the backend ``where`` on each block.

    Between two operations the store has all that it takes to go on (see `Journal`).
    """

    def __init__(self, where: Backend, engine: Engine) -> None:
        device = getattr(where, "chosen_device", None)
        self.place, self.engine, self.dtype = Place(where.name, where.dtype.name, device), engine, where.dtype
        self.folder = (engine.store or Path(mkdtemp(prefix="cnnsim-store-"))).absolute()  # workers began elsewhere
        if engine.store is None:
            finalize(self, rmtree, self.folder, ignore_errors=True)
        self.progress, self.opened, self.runs = ProgramProgress({}), uuid4().hex, 0
        self._unused: list[Path] = []
        self.workers: Workers
        self.journal: Journal
        self.stays = False

    @contextmanager
    def running(
        self, signature: str, shape: tuple[int, ...], shares: Mapping[str, float], *, sleeps: bool, stays: bool
    ) -> Iterator[None]:
        """Run a program in a block: workers are there meanwhile.

        ``signature`` tells the program and its planes from others; ``shares``: of the program, done before each step;
        ``sleeps``: whether blocks may sleep in it; ``stays``: results stay in the store, as Zarr arrays.

        Raises:
            InputError: the store is of something else; no workers.
        """
        self.progress, self.stays = ProgramProgress(shares), stays and self.engine.store is not None
        with open_workers(self.engine.name, self.engine.workers) as self.workers:
            if not self.runs:
                self._open(signature, shape, sleeps=sleeps)
            self.runs += 1
            if self.do(lambda _: signature)[1] != signature:
                raise InputError(f"run {self.runs} in {self.folder} was of other planes; a folder for each wanted")
            yield
            self._delete_unused()

    def _open(self, signature: str, shape: tuple[int, ...], *, sleeps: bool) -> None:
        kept = open_store(self.folder, signature, PROGRAM)
        if kept is None:
            record = ProgramRecord(side_of_blocks(self.engine, shape, self.workers.count, sleeps=sleeps))
        else:
            record = record_of(self.folder, ProgramRecord, kept)
            self.engine.side_of_store(self.folder, record.side)
        self.group = zarr_library().open_group(self.folder, mode="r+")
        self.journal = Journal(self.group, signature, record)

    def do(self, work: Callable[[str], Any]) -> tuple[str, Any]:
        """Do the next operation, and return its name and what it answered, now or when it was done before."""
        name = self.journal.begin()
        if self.journal.done:
            return name, self.journal.answer
        self._delete_unused()
        try:
            answer = work(name)
            self.journal.commit(answer, self.progress.step)
        except (InputError, OSError) as error:
            raise self._kept(error) from error
        return name, answer

    def _kept(self, error: InputError | OSError) -> InputError:
        """Return the error with what the store still has."""
        if isinstance(error, _StoppedError):
            return error
        what = f"{error.strerror or error}" if isinstance(error, OSError) else str(error)
        where = f"{self.progress.step}: " if self.progress.step else ""
        kept = f"; {self.engine.store} keeps what was done before: run again to go on" if self.engine.store else ""
        return _StoppedError(f"{where}{what}{kept}")

    def _delete_unused(self) -> None:
        """Delete the planes that nobody holds; no operation that is still to come was promised them."""
        while self._unused:
            rmtree(self._unused.pop(), ignore_errors=True)

    def blocks(self, shape: tuple[int, ...], boundary: Boundary = ZERO_FLUX) -> Blocks:
        """Return the blocks of planes of this shape."""
        return Blocks((shape[-2], shape[-1]), self.journal.record.side, boundary)

    def plane(self, name: str, shape: tuple[int, ...], memory: Memory, folder: str = "") -> StoredPlane:
        """Return the plane whose array has this name; ``folder``: what goes with it, if that is more."""
        files = PlaneFiles(self.folder / name, shape, self._unused.append, self.folder / (folder or name))
        return StoredPlane(files, memory)

    def create(self, name: str, shape: tuple[int, ...], memory: Memory, fill: float = 0) -> None:
        """Make the array of a plane."""
        create(self.group, name, shape, self.dtype, self.journal.record.side, bits=memory == "llm", fill=fill)

    def tasks(
        self, verb: str, arguments: tuple[Any, ...], takes: Sequence[StoredPlane], gives: Sequence[Path],
        blocks: Blocks, halo: int = 0,
    ) -> list[Any]:  # fmt: skip
        """Do a verb on all blocks, and return the numbers that it gave."""
        taken = tuple((plane.files.path, plane.memory) for plane in takes)
        waiting = [
            PlaneTask(blocks, self.place, block, halo, verb, arguments, taken, tuple(gives), self.opened)
            for block in range(len(blocks))
        ]
        told = self.progress.of_blocks(len(blocks))
        return all_done(self.workers, run_plane_task, waiting, len(blocks), told)

    def made(
        self, verb: str, arguments: tuple[Any, ...], takes: Sequence[StoredPlane], *memories: Memory,
        boundary: Boundary = ZERO_FLUX, halo: int = 0,
    ) -> tuple[StoredPlane, ...]:  # fmt: skip
        """Do a verb that makes planes, in these memories."""
        shape = takes[0].shape

        def work(name: str) -> None:
            names = [f"{name}.{number}" for number in range(len(memories))]
            for each, memory in zip(names, memories, strict=True):
                self.create(each, shape, memory)
            blocks = self.blocks(shape, boundary)
            self.tasks(verb, arguments, takes, [self.folder / each for each in names], blocks, halo)

        name, _ = self.do(work)
        return tuple(self.plane(f"{name}.{number}", shape, memory) for number, memory in enumerate(memories))


class _StoppedError(InputError):
    """An operation failed, and the error says what the store keeps."""
