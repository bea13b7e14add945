"""Programs on large grids: a machine whose planes are Zarr arrays in the store of an engine."""

from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from cnnsim.backends.base import Backend
from cnnsim.program.block_cache import TemplateCache
from cnnsim.program.liveness import used_last
from cnnsim.program.numbering import numbered
from cnnsim.program.program import Program, Step, TemplateStep
from cnnsim.supersteps.block_plan import check_plan
from cnnsim.supersteps.engine import Engine, parse_engine
from cnnsim.supersteps.identity import signature
from cnnsim.supersteps.stored_backend import StoredBackend
from cnnsim.support import InputError, naming
from cnnsim.support.values import is_stored


class OnEngine:
    """The part of a machine that is specific to an engine: checks of the steps, the record, and unused planes."""

    def __init__(self, where: Backend, engine: str | Engine, store: str | Path | None, ways: TemplateCache) -> None:
        self.backend, self._ways = StoredBackend(where, parse_engine(engine, store)), ways
        self._used_last: dict[Step, set[str]] = {}

    @contextmanager
    def running(self, program: Program, planes: Mapping[str, Any]) -> Iterator[None]:
        """Run a program on planes in a block.

        Raises:
            InputError: a step that cannot be computed block by block; the store is of another program.
        """
        shape = next(iter(planes.values())).shape
        self._check_steps(program, shape)
        identity = (
            self.backend.name, self.backend.dtype.str, program.memory, program.inputs, program.outputs, program.keep,
            program.steps, shape,
        )  # fmt: skip
        self._used_last = used_last(program)
        stays = any(is_stored(plane) for plane in planes.values())
        with self.backend.running(signature(identity, dict(planes)), shape, stays=stays):
            yield

    def _check_steps(self, program: Program, shape: tuple[int, ...]) -> None:
        """Check that all transients can be computed block by block."""
        for _, step in numbered(program.steps):
            if not isinstance(step, TemplateStep) or self._ways.rule(program, step) is not None:
                continue
            with naming(step.where):
                if step.accuracy is not None:
                    raise InputError(
                        "accuracy with an engine: an accuracy needs several runs; a step, or no engine, wanted"
                    )
                check_plan(self._ways.plan(step, shape))

    def begins(self, step: Step) -> None:
        """Note the step that comes next."""
        self.backend.step = step.where

    def ended(self, step: Step, planes: dict[str, Any]) -> None:
        """Drop the planes that no later step needs."""
        for name in self._used_last.get(step, ()):
            planes.pop(name, None)
