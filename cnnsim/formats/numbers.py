"""Decimal numbers of text files: parsed strictly, and formatted so that parsing returns the same number."""

import re

from cnnsim.support.errors import InputError

_NUMBER = re.compile(r"[+-]?(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?", re.ASCII)


def is_number(word: str) -> bool:
    """Return whether a word is a decimal number: ``1``, ``-.5``, ``2.``, ``1e-3``; not ``nan``, ``inf`` or ``1_0``."""
    return _NUMBER.fullmatch(word) is not None


def number(word: str) -> float:
    """Parse one number.

    Raises:
        InputError: the word is no number, or too large for a float.
    """
    if not is_number(word):
        hint = "; a decimal point is wanted, not a comma" if is_number(word.replace(",", ".", 1)) else ""
        raise InputError(f"{word[:40]!r} is no number{hint}")
    value = float(word)
    if abs(value) == float("inf"):
        raise InputError(f"{word[:40]!r} is too large")
    return value


def written(value: float) -> str:
    """Return the shortest text that parses to the same number; whole numbers have no decimal point."""
    value = float(value)
    return str(int(value)) if value.is_integer() and abs(value) < 1e15 and str(value) != "-0.0" else repr(value)


def whole(word: str) -> int | None:
    """Return a whole number of at most 6 digits without sign, or None."""
    return int(word) if word.isascii() and word.isdigit() and len(word) <= 6 else None
