"""The strain or stress field at the taxels of one finger over some frames, before any electronics."""

from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import TYPE_CHECKING, Protocol

from cnnsim.support import Floats
from tactile.core.frame import TaxelArray
from tactile.elastic.medium import Medium
from tactile.simulator.contacts.loads import Loads, together
from tactile.simulator.contacts.mounting import STILL, Rig
from tactile.simulator.summation import ACCURACY, field_at
from tactile.simulator.taxels import Taxels

if TYPE_CHECKING:
    from tactile.simulator.bump_cover import Bumps


class Contact(Protocol):
    """Anything that presses on a finger. Contacts add."""

    @property
    def finger(self) -> int: ...  # noqa: D102 - the finger's number
    def loads(self, times: Floats, depth: float, medium: Medium, rig: Rig = ...) -> Loads: ...  # noqa: D102 - what it puts on the finger at the times


@dataclass(frozen=True)
class Field:
    """What the taxels feel, as what it comes from: it is computed when it is asked for, with all effects at once.

    ``contacts`` on this finger; ``times`` (n,) [s]; ``first``: number of the first frame; ``rig``: how contacts are
    held; ``taxels``: where they lie; ``accuracy`` of the peak; ``bumps``: the cover has them.
    """

    array: TaxelArray
    medium: Medium
    times: Floats
    first: int
    contacts: tuple[Contact, ...]
    taxels: Taxels
    rig: Rig = STILL
    accuracy: float = ACCURACY
    bumps: "Bumps | None" = field(default=None, compare=False)

    @property
    def at_points(self) -> bool:
        """Whether every contact is one point load, whatever the cover: a force, with no law of its own."""
        return self.rig.tip == 0 and self.loads.points.shape[1] == len(self.contacts)

    @cached_property
    def loads(self) -> Loads:
        """What presses at the times."""
        parts = (contact.loads(self.times, self.taxels.depth, self.medium, self.rig) for contact in self.contacts)
        return together(parts, len(self.times))

    @cached_property
    def values(self) -> Floats:
        """(n, rows, cols, 3) in the medium's reading."""
        if self.bumps is not None:
            return self.bumps.readings(self.array, self.medium, self.loads)
        return self.taxels.feel(
            lambda at, depth, medium: field_at(at, depth, self.loads, medium, self.accuracy),
            self.medium,
            self.accuracy,
            at_once=True,
        )

    def again(self, accuracy: float, first: int, times: Floats) -> "Field":
        """The same at some of its times, from frame ``first`` on, with what was computed; values may be written into.

        ``accuracy``: of what effects make of it, for which nothing is computed yet.
        """
        made = replace(self, accuracy=accuracy, first=first, times=times)
        part = slice(first, first + len(times))
        loads = self.loads if len(times) == len(self.times) else self.loads.of_frames(part)
        made.__dict__.update(loads=loads, values=self.values[part].copy())
        return made
