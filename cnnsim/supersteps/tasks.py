"""Tasks of all blocks handed to workers, and again where a worker died."""

from collections.abc import Callable, Sequence
from typing import Protocol, TypeVar

from cnnsim.support import InputError
from cnnsim.workers import Lost, Workers

AGAIN = 3
"""How often a block is tried whose worker died."""


class OfBlock(Protocol):
    """A task of a block, which can be run again at any time."""

    @property
    def block(self) -> int:
        """The block's number."""


Task = TypeVar("Task", bound=OfBlock)
Outcome = TypeVar("Outcome")


def all_done(
    workers: Workers,
    function: Callable[[Task], Outcome],
    tasks: Sequence[Task],
    blocks: int,
    told: Callable[[int], None],
) -> list[Outcome]:
    """Return what the function makes of each task, in any order; ``told`` is told how many are done.

    Raises:
        InputError: workers died again and again on a block; ``blocks``: how many there are.
    """
    done: list[Outcome] = []
    for _ in range(AGAIN):
        lost: list[Task] = []
        for outcome in workers.map(function, tasks):
            if isinstance(outcome, Lost):
                lost.append(outcome.task)
                continue
            done.append(outcome)
            told(len(done))
        tasks = lost
        if not tasks:
            return done
    raise InputError(
        f"a worker process died {2 * AGAIN} times on block {tasks[0].block} of {blocks}; smaller blocks, or workers "
        "with more memory, wanted"
    )
