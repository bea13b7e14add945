"""InputError: the exception for whatever a user can get wrong."""

from collections.abc import Iterator
from contextlib import contextmanager


class InputError(ValueError):
    """Something given from outside is wrong; the message says what was given and what was wanted.

    The command line prints it as one line on stderr and leaves with exit code 2.
    """


@contextmanager
def naming(where: object) -> Iterator[None]:
    """Lead the message of an InputError with the place where it arose."""
    try:
        yield
    except InputError as error:
        raise InputError(f"{where}: {error}") from error
