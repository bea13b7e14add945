"""The nearest of some words to one that is not among them, for messages."""

from collections.abc import Collection
from difflib import get_close_matches

from cnnsim.support.errors import InputError, shown


def not_known(what: str, given: object, known: Collection[str]) -> InputError:
    """Return the error for a word that is not known; it has all that are, and the nearest."""
    return InputError(f"{what} {shown(given)}; known are {', '.join(known)}{did_you_mean(given, known)}")


def did_you_mean(given: object, known: Collection[str]) -> str:
    """Return "; did you mean 'zero-flux'?", nothing where none is near."""
    near = get_close_matches(given.lower(), known, 1) if isinstance(given, str) else []
    return f"; did you mean {near[0]!r}?" if near else ""
