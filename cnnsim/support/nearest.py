"""The nearest of some words to one that is not among them, for messages; capitals make no difference."""

from collections.abc import Collection
from difflib import get_close_matches

from cnnsim.support.errors import InputError, shown


def not_known(what: str, given: object, known: Collection[str]) -> InputError:
    """Return the error for a word that is not known; it has all that are, and the nearest."""
    return InputError(f"{what} {shown(given)}; known are {', '.join(known)}{did_you_mean(given, known)}")


def did_you_mean(given: object, known: Collection[str]) -> str:
    """Return "; did you mean 'zero-flux'?", nothing where none is near."""
    near = nearest(given, known)
    return "" if near is None else f"; did you mean {near!r}?"


def nearest(given: object, known: Collection[str]) -> str | None:
    """Return the nearest word, None where none is near."""
    words = {one.lower(): one for one in known}
    near = get_close_matches(given.lower(), words, 1) if isinstance(given, str) else []
    return words[near[0]] if near else None
