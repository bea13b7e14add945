"""List of the errors of one file: collected while it is read, and raised together."""

from collections.abc import Callable, Collection, Iterator, Mapping
from contextlib import contextmanager, nullcontext
from typing import Any

from cnnsim.support.errors import InputError, MissingKeyError, SeveralFaultsError, naming
from cnnsim.support.toml_file import MOST_FAULTS, check_keys, located


class ErrorList:
    """The errors of one file, each once; ``where`` names the file in the message.

    After a `check` has reported missing keys, a `MissingKeyError` of a later reader is not added.
    """

    def __init__(self, where: str = "") -> None:
        self._where = where
        self._found: dict[str, InputError] = {}
        self._missing_known = False

    def __len__(self) -> int:
        return len(self._found)

    def check(self, table: Any, known: Collection[str], place: str = "", required: Collection[str] = ()) -> None:
        """Check the keys of a table with `check_keys`; ``place`` names the table in messages."""
        with self.collecting():
            check_keys(table, known, place, required)
        self._missing_known |= not isinstance(table, Mapping) or not set(required) <= table.keys()

    @contextmanager
    def collecting(self, table: Any = None, key: str | None = None, where: str = "") -> Iterator[None]:
        """Add an InputError raised in the block to the list, and continue after the block.

        The message begins with ``where`` and ends with the line number of ``table`` or of its ``key``, if given.
        """
        try:
            with located(table, key), naming(where) if where else nullcontext():
                yield
        except InputError as error:
            for one in error.faults if isinstance(error, SeveralFaultsError) else (error,):
                if not (self._missing_known and isinstance(one, MissingKeyError)):
                    self._found.setdefault(str(one).removeprefix(f"{self._where}: "), one)

    def raise_all(self) -> None:
        """Raise all errors of the list as one InputError; do nothing if there are none."""
        if self._found:
            more = [f"and {len(self) - MOST_FAULTS} more"] if len(self) > MOST_FAULTS else []
            text = "; ".join(list(self._found)[:MOST_FAULTS] + more)
            raise SeveralFaultsError(f"{self._where}: {text}" if self._where else text, [*self._found.values()])


def read_all(where: str, *readers: Callable[[], Any]) -> list[Any]:
    """Return what each of the readers returns; their errors are raised together, led by ``where``."""
    errors, found = ErrorList(where), []
    for read in readers:
        with errors.collecting():
            found.append(read())
    errors.raise_all()
    return found
