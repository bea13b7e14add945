"""InputError: the exception for whatever a user can get wrong."""

from collections.abc import Callable, Collection, Sequence
from difflib import get_close_matches


class InputError(ValueError):
    """Something given from outside is wrong; the message says what was given and what was wanted.

    The command line prints it as one line on stderr and leaves with exit code 2.
    """


class MissingKeyError(InputError):
    """A key that a table of a file has to have is not there."""


class SeveralFaultsError(InputError):
    """Several things that are wrong, each an error of its own in ``faults``; the message tells them all."""

    def __init__(self, text: str, faults: Sequence[InputError]) -> None:
        super().__init__(text)
        self.faults = tuple(faults)


def reworded(error: InputError, words: Callable[[str], str]) -> InputError:
    """Return an error with another message, of several faults each with another one."""
    text = words(str(error))
    if isinstance(error, SeveralFaultsError):
        return SeveralFaultsError(text, [reworded(one, words) for one in error.faults])
    return MissingKeyError(text) if isinstance(error, MissingKeyError) else InputError(text)


SHOWN = 120
"""Characters of a value that a message shows: whole matrices and pictures would bury what is wanted."""


def shown(value: object) -> str:
    """Return a value as Python writes it, cut where it is long."""
    return cut(repr(value))


def cut(text: str) -> str:
    """Return a text, cut where it is long."""
    return text if len(text) <= SHOWN else text[:SHOWN] + " ..."


class naming:  # noqa: N801 - it reads as a word after "with"; a generator would cost a step of a program a microsecond
    """Lead the message of an InputError with the place where it arose."""

    __slots__ = ("_where",)

    def __init__(self, where: object) -> None:
        self._where = where

    def __enter__(self) -> None: ...

    def __exit__(self, _kind: object, error: BaseException | None, _trace: object) -> None:
        if isinstance(error, InputError):
            raise reworded(error, lambda text: f"{self._where}: {text}") from error


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
