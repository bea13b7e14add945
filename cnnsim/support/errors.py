"""InputError, the exception for wrong input; the parts of its messages; diagnostics of an imported file."""

from collections.abc import Callable, Collection, Sequence
from dataclasses import dataclass, field
from difflib import get_close_matches
from typing import Literal


class InputError(ValueError):
    """Wrong input: the message has the value found and the values expected.

    Command lines print it as one line on stderr and exit with code 2.
    """


class MissingKeyError(InputError):
    """A required key of a table in a file is missing."""


class SeveralFaultsError(InputError):
    """Several errors of one file: ``faults`` has each, the message has all."""

    def __init__(self, text: str, faults: Sequence[InputError]) -> None:
        super().__init__(text)
        self.faults = tuple(faults)


def reworded(error: InputError, words: Callable[[str], str]) -> InputError:
    """Return an error of the same kind with its message, or each of its messages, changed by ``words``."""
    text = words(str(error))
    if isinstance(error, SeveralFaultsError):
        return SeveralFaultsError(text, [reworded(one, words) for one in error.faults])
    return MissingKeyError(text) if isinstance(error, MissingKeyError) else InputError(text)


SHOWN = 120
"""Characters of a value in a message; a whole matrix would hide the rest."""


def shown(value: object) -> str:
    """Return the repr of a value, cut to `SHOWN` characters."""
    return cut(repr(value))


def cut(text: str) -> str:
    """Return a text, cut to `SHOWN` characters."""
    return text if len(text) <= SHOWN else text[:SHOWN] + " ..."


class naming:  # noqa: N801 - it reads as a word after "with"; a generator would cost a step of a program a microsecond
    """Put ``where`` in front of the message of an InputError."""

    __slots__ = ("_where",)

    def __init__(self, where: object) -> None:
        self._where = where

    def __enter__(self) -> None: ...

    def __exit__(self, _kind: object, error: BaseException | None, _trace: object) -> None:
        if isinstance(error, InputError):
            raise reworded(error, lambda text: f"{self._where}: {text}") from error


def not_known(what: str, given: object, known: Collection[str]) -> InputError:
    """Return the error for an unknown word; it lists the known ones and the nearest."""
    return InputError(f"{what} {shown(given)}; known are {', '.join(known)}{did_you_mean(given, known)}")


def did_you_mean(given: object, known: Collection[str]) -> str:
    """Return "; did you mean 'zero-flux'?", or an empty text if no known word is similar."""
    near = nearest(given, known)
    return "" if near is None else f"; did you mean {near!r}?"


def nearest(given: object, known: Collection[str]) -> str | None:
    """Return the most similar known word in any case of letters, or None."""
    words = {one.lower(): one for one in known}
    near = get_close_matches(given.lower(), words, 1) if isinstance(given, str) else []
    return words[near[0]] if near else None


Severity = Literal["note", "warning", "error"]


@dataclass(frozen=True)
class Diagnostic:
    """One remark. A note is harmless, a warning should be checked, after an error the content cannot be trusted."""

    severity: Severity
    line: int | None
    message: str


@dataclass
class Diagnostics:
    """The remarks on one file, in the order in which they were found."""

    file: str
    items: list[Diagnostic] = field(default_factory=list)

    def note(self, line: int | None, message: str) -> None:
        """Add a harmless remark."""
        self.items.append(Diagnostic("note", line, message))

    def warning(self, line: int | None, message: str) -> None:
        """Add a remark that should be checked."""
        self.items.append(Diagnostic("warning", line, message))

    def error(self, line: int | None, message: str) -> None:
        """Add an error: the content cannot be trusted."""
        self.items.append(Diagnostic("error", line, message))

    def of(self, severity: Severity) -> list[Diagnostic]:
        """Return the remarks of one severity."""
        return [item for item in self.items if item.severity == severity]

    @property
    def failed(self) -> bool:
        """True if there is an error."""
        return bool(self.of("error"))

    def lines(self, notes: bool = False) -> list[str]:
        """Return the remarks as ``file:line: severity: message``, notes only if asked for."""
        return [
            f"{self.file}:{'' if item.line is None else f'{item.line}:'} {item.severity}: {item.message}"
            for item in self.items
            if notes or item.severity != "note"
        ]
