"""Event codes: encode traction planes as CNN inputs, decode comparator outputs to a ternary code."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from cnnsim.support import Flags, Floats
from tactile.core.frame import NORMAL, Frame, Quantity
from tactile.thresholds.threshold import Threshold

_ARROWS = {
    (0, 0): "·", (1, 0): "→", (-1, 0): "←", (0, 1): "↓", (0, -1): "↑", (1, 1): "↘", (1, -1): "↗", (-1, 1): "↙",
    (-1, -1): "↖",
}  # fmt: skip
"""A taxel's ternary code as an arrow; y points down, as in CONVENTIONS.md."""


def encode(frame: Frame, quantity: Quantity, shear: Threshold, contact: Threshold) -> dict[str, Floats]:
    """Return the planes shear_x, shear_y and pressing (rows, cols) as CNN values in [-1, 1].

    Pressing is +normal for force, -normal for strain and stress (eqs (1), (10): u_zz < 0 under a pressing load).
    Invalid taxels and non-finite readings become 0, which is no code.
    """
    use = frame.valid[..., None] & np.isfinite(frame.values)
    values = np.where(use, frame.values, 0.0)
    return encode_values(values, quantity, shear, contact)


def encode_values(values: Floats, quantity: Quantity, shear: Threshold, contact: Threshold) -> dict[str, Floats]:
    """Return the planes of `encode` for finite values (rows, cols, 3)."""
    inward = 1.0 if quantity == "force" else -1.0
    scaled = np.empty((3, *values.shape[:2]))
    scaled[:NORMAL] = values[..., :NORMAL].transpose(2, 0, 1) / shear.full_scale
    scaled[NORMAL] = values[..., NORMAL] * (inward / contact.full_scale)
    shear_x, shear_y, pressing = np.minimum(np.maximum(scaled, -1), 1)
    return {"shear_x": shear_x, "shear_y": shear_y, "pressing": pressing}


@dataclass(frozen=True)
class Code:
    """Comparator outputs of one finger: ternary planes ``x``, ``y`` of -1, 0, +1 and ``contact`` (rows, cols)."""

    x: NDArray[np.int8]
    y: NDArray[np.int8]
    contact: Flags

    def arrows(self) -> str:
        """Return one arrow per taxel, row by row, with a space between rows."""
        rows = zip(self.x.tolist(), self.y.tolist(), strict=True)
        return " ".join("".join(_ARROWS[cell] for cell in zip(*row, strict=True)) for row in rows)

    def ternary(self) -> str:
        """Return two characters of -, 0, + per taxel (x, then y), row by row."""
        return self._ternary

    @cached_property
    def _ternary(self) -> str:  # wanted for every frame, of a code that seldom changes
        return "".join("0+-"[value] for value in np.stack((self.x, self.y), axis=-1).ravel().tolist())

    @cached_property
    def pressed(self) -> int:
        """Number of taxels in contact."""
        return int(self.contact.sum())

    def direction(self) -> str:
        """Return the majority direction of the shear: "+x", "-y", "+x -y", or "about a point" without a majority."""
        votes = (int(self.x.sum()), int(self.y.sum()))
        most = max(abs(vote) for vote in votes)
        if most == 0:
            return "about a point"
        return " ".join(
            f"{'+' if vote > 0 else '-'}{axis}" for vote, axis in zip(votes, "xy", strict=True) if 2 * abs(vote) > most
        )

    def signs(self) -> int:
        """Return the paper's binary code: two bits per taxel (x, then y; 1 is plus), row by row, first highest."""
        bits = np.stack((self.x, self.y), axis=-1).ravel() > 0
        return int("".join("1" if bit else "0" for bit in bits.tolist()), 2)


def decode(planes: dict[str, Flags]) -> Code:
    """Return the code of the comparator planes x_plus, x_minus, y_plus, y_minus and contact."""
    x, y = (planes[f"{axis}_plus"].astype(np.int8) - planes[f"{axis}_minus"].astype(np.int8) for axis in "xy")
    return Code(x, y, planes["contact"])


def hand_code(fingers: list[Code]) -> int:
    """Return the fingers' sign codes as one number, the first finger highest: 16 bits for two 2 x 2 arrays."""
    number = 0
    for code in fingers:
        number = number << 2 * code.x.size | code.signs()
    return number
