"""Tolerance of a transient: the largest error of a state, or only the signs of the outputs."""

from dataclasses import dataclass
from typing import Any

from cnnsim.support import InputError, naming
from cnnsim.support.values import is_number

Accuracy = float | str
"""A number, "binary" or "exact"; the command line has the number as text."""

FLOAT32 = 3e-4
"""The smallest tolerance in float32: in one of 20 of 400 random transients, its rounding error was above 2e-5."""
EXACT = 1e-10
LEAST = 1e-12
"""Sums of a hundred steps in float64 are no more accurate than that."""


@dataclass(frozen=True)
class Tolerance:
    """``error``: the largest |x - truth|; ``signs``: only the signs of the outputs count."""

    error: float
    signs: bool = False

    @property
    def dtype(self) -> str:
        """The smallest dtype whose rounding errors are below the tolerance."""
        return "float32" if self.error >= FLOAT32 else "float64"

    def __str__(self) -> str:
        return "the signs of all outputs" if self.signs else f"{self.error:g}"


def read_accuracy(data: dict[str, Any], where: str) -> Accuracy | None:
    """Return the accuracy in a table of a file, None if it has none.

    Raises:
        InputError: the value is not an accuracy.
    """
    if "accuracy" not in data:
        return None
    with naming(where):
        parse_accuracy(data["accuracy"])
    return data["accuracy"]


def parse_accuracy(value: Any) -> Tolerance:
    """Read an accuracy: a number, ``"binary"``, ``"exact"``, or a number as the command line writes it.

    Raises:
        InputError: anything else, or more than float64 can give.
    """
    if value == "binary":
        return Tolerance(0.03, signs=True)
    if value == "exact":
        return Tolerance(EXACT)
    if isinstance(value, str):
        try:
            value = float(value)
        except ValueError:
            value = str(value)
    if not is_number(value) or not 0 < value <= 1:
        raise InputError(f"accuracy {value!r}; a number from {LEAST:g} to 1, 'binary' or 'exact' wanted")
    if value < LEAST:
        raise InputError(f"accuracy {value:g}; float64 can give no more than {LEAST:g}")
    return Tolerance(float(value))
