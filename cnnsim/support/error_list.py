"""Faults of a file that people write: all of them collected, each with its line, and told at once."""

from collections.abc import Callable, Collection, Iterator, Mapping
from contextlib import contextmanager
from typing import Any

from cnnsim.support.errors import InputError, MissingKeyError, SeveralFaultsError
from cnnsim.support.toml_file import MOST_FAULTS, check_keys


class ErrorList:
    """Collects what is wrong with the keys of a file, and with their values, to be told at once, the same thing once.

    ``where`` names the file, unless that is done outside; the length is how many faults there are. Once a `check` has
    told of missing keys, that one is missing is no further fault.
    """

    def __init__(self, where: str = "") -> None:
        self._where = where
        self._found: dict[str, InputError] = {}
        self._told_missing = False

    def __len__(self) -> int:
        return len(self._found)

    def check(self, table: Any, known: Collection[str], place: str = "", required: Collection[str] = ()) -> None:
        """Check a table as `check_keys`; ``place`` names it in messages."""
        with self.collecting():
            check_keys(table, known, place, required)
        self._told_missing |= not isinstance(table, Mapping) or not set(required) <= table.keys()

    @contextmanager
    def collecting(self) -> Iterator[None]:
        """Take what the block refuses for one fault more, or several, and go on after it."""
        try:
            yield
        except SeveralFaultsError as several:
            for error in several.faults:
                self._add(error)
        except InputError as error:
            self._add(error)

    def _add(self, error: InputError) -> None:
        if not (self._told_missing and isinstance(error, MissingKeyError)):
            self._found.setdefault(str(error).removeprefix(f"{self._where}: "), error)

    def tell(self) -> None:
        """Refuse the file if anything was found.

        Raises:
            InputError: all that was found.
        """
        if self._found:
            told = list(self._found)
            more = [f"and {len(self) - MOST_FAULTS} more"] if len(self) > MOST_FAULTS else []
            lead = f"{self._where}: " if self._where else ""
            text = lead + "; ".join(told[:MOST_FAULTS] + more)
            raise SeveralFaultsError(text, list(self._found.values()))


def read_all(where: str, *readers: Callable[[], Any]) -> list[Any]:
    """Return what each of some readers returns; what any of them refuses is told at once, ``where`` said once.

    Raises:
        InputError: what they raise, all of it.
    """
    faults, found = ErrorList(where), []
    for read in readers:
        with faults.collecting():
            found.append(read())
    faults.tell()
    return found
