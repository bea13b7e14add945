"""How far an Euler transient has come, so that it can be run slice by slice."""

from typing import NamedTuple

from cnnsim.backends.cpu.jit.compile import helper
from cnnsim.backends.cpu.tiles.grid import Schedule

BEGIN, CHECK, MEASURE, STEP, END = range(5)
"""Phases: nothing is done; a check; a check of all tiles that also measures the rate; a pass of steps; all is done."""
PHASE = 2


class Position(NamedTuple):
    """The steps ``done``; ``where`` the state is (0: in x itself, 1 or 2: in the planes between which steps go);
    the ``phase``, and which tile, or place in the list of tiles, is next in it (0: the phase is to begin).

    Where tiles sleep, ``now`` are the steps of this pass and ``to_do`` the tiles in the list, which is gone through
    twice.
    """

    done: int
    where: int
    phase: int
    next: int
    now: int
    to_do: int


Fields = tuple[int, int, int, int, int, int]
"""A `Position` as a bare tuple: see `cnnsim.backends.cpu.prepared`."""
START: Fields = 0, 0, BEGIN, 0, 0, 0


@helper
def phase_at(done: int, schedule: Schedule) -> int:
    """Return what is to be done after so many steps."""
    steps, check_every, _, _ = schedule
    if done == steps:
        return MEASURE if check_every > 0 else END
    return CHECK if check_every > 0 and done % check_every == 0 else STEP
