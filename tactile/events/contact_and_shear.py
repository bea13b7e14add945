"""Contact and shear directions of the taxels: events from changes of a finger's code."""

import numpy as np

from tactile.events.code import Code
from tactile.events.detector import Observation
from tactile.events.event import Data, EventKind, Happening


class TouchKind(EventKind):
    """Kinds of change of the code; ``direction`` by majority of the taxels, ``taxels`` that touch or feel shear."""

    CONTACT = "contact"
    RELEASE = "release"
    CONTACT_CHANGES = "contact on {taxels} of {of_taxels} taxels"
    SHEAR_BEGINS = "shear {direction}"
    SHEAR_TURNS = "shear turns {direction}"
    SHEAR_SPREADS = "shear {direction} spreads"
    SHEAR_FADES = "shear {direction} fades"
    SHEAR_SHIFTS = "shear {direction} shifts"
    SHEAR_GONE = "shear gone"


class ContactAndShear:
    """Names each change of the taxels' code: contact first, else what becomes of the shear, else the contact's area."""

    def detect(self, seen: Observation) -> list[Happening]:
        """Return the one event that a changed code is."""
        return [_change(seen.before, seen.code)] if seen.changed else []


def _change(before: Code, after: Code) -> Happening:
    touched, touches = bool(before.contact.any()), bool(after.contact.any())
    earlier, count = _signs(before), _signs(after)
    if touches != touched or count == earlier == 0:
        kind = TouchKind.CONTACT_CHANGES if touches == touched else TouchKind.CONTACT if touches else TouchKind.RELEASE
        return kind, {"taxels": int(after.contact.sum()), "of_taxels": after.contact.size}
    if count == 0:
        return TouchKind.SHEAR_GONE, {}
    old, new = before.direction(), after.direction()
    data: Data = {"direction": new, "taxels": int(np.count_nonzero((after.x != 0) | (after.y != 0)))}
    if earlier == 0:
        return TouchKind.SHEAR_BEGINS, data
    if new != old:
        return TouchKind.SHEAR_TURNS, {**data, "from_direction": old}
    if count == earlier:
        return TouchKind.SHEAR_SHIFTS, data
    return TouchKind.SHEAR_SPREADS if count > earlier else TouchKind.SHEAR_FADES, data


def _signs(code: Code) -> int:
    """Return how many shear components of all taxels have a sign."""
    return int(np.count_nonzero(code.x) + np.count_nonzero(code.y))
