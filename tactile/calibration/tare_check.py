"""Check of a tare: how much was subtracted, and whether the array was loaded or moving."""

from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from cnnsim.support import Floats
from tactile.core.frame import NORMAL, Quantity, TaxelArray
from tactile.thresholds.threshold import CONTACT, SHEAR

PARTS = 10
"""Parts of the tare whose means are compared: averages suppress the noise of single frames."""
LARGE = 4.0
"""Limit of one taxel [dead bands]: a larger offset may be a load, a larger change is a movement."""
BOTH = 2.0
"""Limit of two taxels [dead bands]: larger changes of both are a movement."""
SPREAD = 3.0
"""Limit of the sum of offsets [dead bands times the root of the number of taxels]: offsets have random signs, loads
the same."""
UNITS: dict[Quantity, tuple[float, str]] = {"force": (1.0, "N"), "strain": (1e3, "‰"), "stress": (1e-3, "kPa")}
"""Factor and unit for display."""
CURE = "record some frames with nothing touching first, or choose --tare N (0 for none)"


@dataclass(frozen=True)
class TareCheck:
    """Offset that a tare subtracted from one finger, in the unit of the array's quantity.

    ``frames`` averaged over ``seconds`` [s]; ``normal``: sum of the pressing of all taxels; ``shear``: length of the
    sum of their shear; ``largest``: largest component of a taxel over its dead band; ``moved``: largest change of a
    component between tenths of the tare; ``below``: by how much the sum of later readings is below the tare, which
    shows that the finger was pressed; ``loaded`` and ``moving``: whether these exceed usual offsets and noise.
    """

    finger: str
    quantity: Quantity
    frames: int
    seconds: float
    normal: float
    shear: float
    largest: float
    moved: float
    moving: bool
    loaded: bool
    below: float = 0.0
    late: float = 0.0

    @property
    def words(self) -> str:
        """The subtracted offset and the warning, in one line."""
        what = f"{self.amount} subtracted, the mean of {self.frames} frames ({self.seconds:.3g} s)"
        return what if not self.warning else f"{what}; {self.warning}"

    @property
    def amount(self) -> str:
        """The normal and the shear offset."""
        return f"{self._measure(self.normal)} normal, {self._measure(self.shear)} shear"

    @property
    def warning(self) -> str:
        """The fault and its remedy; empty if there is none."""
        found = []
        if self.below:
            found.append(f"pressed during the tare: later readings fall {self._measure(self.below)} below it")
        elif self.loaded:
            found.append("loaded during the tare, or an offset of that size")
        if self.moving:
            found.append(f"moving during the tare, a taxel by {self._measure(self.moved)}")
        warning = f"{' and '.join(found)}: {CURE}" if found else ""
        if not self.late:
            return warning
        before = f"taken only after {self.late:.3g} s, before which there are no readings, nor events"
        return f"{before}; {warning}" if warning else f"{before}: {CURE}"

    def _measure(self, value: float) -> str:
        return measure(value, self.quantity)

    def then(self, lowest: float, taxels: int) -> "TareCheck":
        """Return the check after later readings, whose total normal force was ``lowest`` at least."""
        limit = max(LARGE, SPREAD * taxels**0.5) * CONTACT[self.quantity].dead_band
        return replace(self, below=-lowest, loaded=True) if lowest < -limit else self

    def plain(self) -> dict[str, Any]:
        """Return the figures as plain data for JSON."""
        unit = {"force": "N", "strain": "1", "stress": "Pa"}[self.quantity]
        return {
            "frames": self.frames, "seconds": self.seconds, "unit": unit, "normal": self.normal, "shear": self.shear,
            "moved": self.moved, "below": self.below, "loaded": self.loaded, "moving": self.moving,
            "warning": self.warning,
        }  # fmt: skip


@dataclass(frozen=True)
class TareNote:
    """Result of a block: ``offset`` (rows, cols, 3) if it was taken, else None, and ``why``.

    ``detail``: how much was subtracted and which taxels are left out, or what was wrong and what to do; empty for
    automatic renewals. ``check``: figures of the first offset. ``notice``: a fault of the stream that users are shown.
    """

    finger: int
    t: float
    why: str
    offset: Floats | None
    detail: str = ""
    check: TareCheck | None = None
    notice: bool = False


def gap_note(finger: int, last: float, t: float) -> TareNote:
    """Return the note on a gap between the frames at ``last`` and ``t`` [s]."""
    gap = f"no frames from {last:.3f} to {t:.3f} s"
    return TareNote(finger, t, gap, None, "all events end, and a new tare is taken", notice=True)


def end_note(finger: int, t: float, words: str) -> TareNote:
    """Return the note on saturated taxels at ``t`` [s]."""
    return TareNote(finger, t, words, None, "their newtons, and the sum, are lower bounds", notice=True)


def measure(value: float, quantity: Quantity) -> str:
    """Return a value for display, with its unit."""
    factor, unit = UNITS[quantity]
    return f"{round(value * factor, 2) + 0.0:.2f} {unit}"  # no -0


def check_tare(array: TaxelArray, parts: Floats, frames: int, seconds: float) -> TareCheck:
    """Return the check of a tare over ``frames`` frames in ``seconds`` [s].

    Arguments: ``parts`` (n, rows, cols, 3): the means of n equal parts of the stretch, in the unit of the array's
    quantity, NaN where a taxel had no reading.
    """
    bands = np.array([SHEAR[array.quantity].dead_band] * NORMAL + [CONTACT[array.quantity].dead_band])
    inward = 1.0 if array.quantity == "force" else -1.0
    known = np.isfinite(parts)
    mean = np.where(known, parts, 0.0).sum(axis=0) / np.maximum(known.sum(axis=0), 1)
    low = np.where(known, parts, np.inf).min(axis=0)
    moves = np.where(known.any(axis=0), np.where(known, parts, -np.inf).max(axis=0) - low, 0.0)
    moved = (moves / bands).argmax()
    by_taxel = np.sort((moves / bands).max(axis=-1), axis=None)
    x, y, normal = mean.reshape(-1, 3).sum(axis=0)
    largest, shear = float((np.abs(mean) / bands).max()), float(np.hypot(x, y))
    most = SPREAD * (array.rows * array.cols) ** 0.5
    return TareCheck(
        finger=array.name,
        quantity=array.quantity,
        frames=frames,
        seconds=seconds,
        normal=float(inward * normal) + 0.0,
        shear=shear,
        largest=largest,
        moved=float(moves.ravel()[moved]),
        # one taxel that is noisier than a dead band is no movement of the array
        moving=bool(by_taxel[-1] > LARGE or (by_taxel.size > 1 and by_taxel[-2] > BOTH)),
        loaded=bool(largest > LARGE or abs(normal) > most * bands[NORMAL] or shear > most * bands[0]),
    )
