"""Events: what a change of code means to a hand."""

from dataclasses import dataclass
from typing import Self

import numpy as np

from tactile.core.frame import Frame, TaxelArray
from tactile.events.code import Code
from tactile.events.slip import Slip
from tactile.inverse.localise import Load


@dataclass(frozen=True)
class Event:
    """One tactile event of one finger.

    ``t`` [s]; ``code`` the finger's arrows, ``ternary`` the same in -0+; ``hand`` the sign code of all fingers;
    ``latency`` [s] from the frame's arrival in the pipeline to this event; ``load`` the one located in that frame.
    """

    t: float
    finger: str
    sequence: int
    code: str
    ternary: str
    hand: int
    meaning: str
    latency: float
    load: Load | None

    @classmethod
    def of(
        cls, frame: Frame, array: TaxelArray, code: Code, hand: int, what: str, latency: float, load: Load | None
    ) -> Self:
        """Return the event that ``what`` happened in this frame."""
        return cls(frame.t, array.name, frame.sequence, code.arrows(), code.ternary(), hand, what, latency, load)


def meaning(before: Code, after: Code) -> str:
    """Say in words what the change from one code to the next is."""
    touched, touches = bool(before.contact.any()), bool(after.contact.any())
    if touches != touched:
        return "contact" if touches else "release"
    old, new = direction(before), direction(after)
    count = int(np.count_nonzero(after.x) + np.count_nonzero(after.y))
    earlier = int(np.count_nonzero(before.x) + np.count_nonzero(before.y))
    if count == earlier == 0:
        return f"contact on {int(after.contact.sum())} of {after.contact.size} taxels"
    if count == 0:
        return "shear gone"
    if earlier == 0:
        return f"shear {new}"
    if new != old:
        return f"shear turns {new}"
    return f"shear {new} {'spreads' if count > earlier else 'fades' if count < earlier else 'shifts'}"


def load_meaning(before: Code, after: Code, load: Load) -> list[str]:
    """Say in words how the tangential part of the whole finger's load changes; nothing if only the normal part does."""
    if np.array_equal((before.x, before.y), (after.x, after.y)):
        return []
    if not (after.x.any() or after.y.any()):
        return ["tangential load gone"]
    return [f"tangential load {direction(after)}: {float(np.hypot(load.Q, load.R)):.2f} N"]


def direction(code: Code) -> str:
    """Return where the taxels' shear points by majority: "+x", "-y", "+x -y", or "about a point" if they disagree."""
    votes = (int(code.x.sum()), int(code.y.sum()))
    most = max(abs(vote) for vote in votes)
    if most == 0:
        return "about a point"
    return " ".join(
        f"{'+' if vote > 0 else '-'}{axis}" for vote, axis in zip(votes, "xy", strict=True) if 2 * abs(vote) > most
    )


def slip_meaning(slip: Slip) -> str:
    """Say a slip in words, with its length and its main direction."""
    along_y = abs(slip.dy) >= abs(slip.dx)
    way = ("-" if (slip.dy if along_y else slip.dx) < 0 else "+") + ("y" if along_y else "x")
    length = float(np.hypot(slip.dx, slip.dy)) * 1e3
    return f"slip begins toward {way}" if slip.begins else f"slip ends: {length:.2f} mm toward {way}"
