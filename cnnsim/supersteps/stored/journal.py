"""Journal of a program in a store: how many of its operations are done, and what they answered.

A program always takes the same way from the same answers. So one that was stopped is begun anew, is told the answers
of the operations that are done, and goes on with the first that is not: registers, loops and planes are then as they
were. Names of planes are the numbers of the operations that made them.
"""

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import asdict, dataclass, field
from typing import Any

from cnnsim.supersteps.store import put_record

PROGRAM = "cnnsim program"
"""What the store of a program is of."""


@dataclass
class ProgramRecord:
    """Operations that are ``done``, the ``step`` of the last one, what they answered; the ``side`` of the blocks."""

    side: int
    done: int = 0
    step: str = ""
    answers: dict[str, Any] = field(default_factory=dict)


class Journal:
    """The operations of a program as they come, those that are done already among them."""

    def __init__(self, group: Any, run: str, record: ProgramRecord) -> None:
        self._group, self.run, self.record = group, run, record
        self._number = self._inner = 0
        self._inside = False

    def begin(self) -> str:
        """Take the next operation and return its name."""
        if self._inside:
            self._inner += 1
            return f"{self._number:06d}-{self._inner}"
        self._number += 1
        return f"{self._number:06d}"

    @property
    def done(self) -> bool:
        """Whether the operation that has begun was done before."""
        return not self._inside and self._number <= self.record.done

    @property
    def answer(self) -> Any:
        """What it answered then."""
        return self.record.answers.get(str(self._number))

    def commit(self, answer: Any, step: str) -> None:
        """Note that the operation is done; one inside another is done when that is."""
        if self._inside:
            return
        if answer is not None:
            self.record.answers[str(self._number)] = answer
        self.record.done, self.record.step = self._number, step
        put_record(self._group, self.run, asdict(self.record), PROGRAM)

    @contextmanager
    def inside(self) -> Iterator[None]:
        """Take operations as parts of the one that has begun."""
        self._inside, self._inner = True, 0
        try:
            yield
        finally:
            self._inside = False
