"""The strain or stress field at the taxels of one finger over some frames, before any electronics."""

from dataclasses import dataclass, field
from functools import cached_property
from typing import TYPE_CHECKING, Protocol

from cnnsim.support import Floats
from tactile.core.frame import TaxelArray
from tactile.elastic.medium import Medium
from tactile.simulator.contacts.loads import Loads, together
from tactile.simulator.contacts.mounting import STILL, Rig
from tactile.simulator.summation import ACCURACY, field_at
from tactile.simulator.taxels import TaxelLayout

if TYPE_CHECKING:
    from tactile.simulator.bump_cover import Bumps


class Contact(Protocol):
    """Anything that presses on a finger. Contacts add."""

    @property
    def finger(self) -> int: ...  # noqa: D102 - the finger's number
    def loads(self, times: Floats, depth: float, medium: Medium, rig: Rig = ...) -> Loads: ...  # noqa: D102 - what it puts on the finger at the times


@dataclass(frozen=True)
class Field:
    """The readings of ideal electronics, described by what they are computed from, effects on fields included.

    ``contacts`` on this finger; ``times`` (n,) [s]; ``first``: number of the first frame; ``rig``: how contacts are
    held; ``taxels``: where they lie; ``accuracy`` relative to the peak; ``bumps`` of the cover, None for a flat one.
    """

    array: TaxelArray
    medium: Medium
    times: Floats
    first: int
    contacts: tuple[Contact, ...]
    taxels: TaxelLayout
    rig: Rig = STILL
    accuracy: float = ACCURACY
    bumps: "Bumps | None" = field(default=None, compare=False)

    @cached_property
    def loads(self) -> Loads:
        """The loads of all contacts at the times."""
        parts = (contact.loads(self.times, self.taxels.depth, self.medium, self.rig) for contact in self.contacts)
        return together(parts, len(self.times))

    @cached_property
    def values(self) -> Floats:
        """(n, rows, cols, 3) in the quantity of the array: that of the medium, or force [N]."""
        if self.array.quantity == "force":
            from tactile.simulator.force_pad import taxel_forces  # only where called for

            return taxel_forces(self)
        if self.bumps is not None:
            return self.bumps.readings(self.array, self.medium, self.loads)
        return self.taxels.measure(
            lambda at, depth, medium: field_at(at, depth, self.loads, medium, self.accuracy),
            self.medium,
            self.accuracy,
            at_once=True,
        )
