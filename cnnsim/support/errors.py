"""InputError: the exception for whatever a user can get wrong."""


class InputError(ValueError):
    """Something given from outside is wrong; the message says what was given and what was wanted.

    The command line prints it as one line on stderr and leaves with exit code 2.
    """


class naming:  # noqa: N801 - it reads as a word after "with"; a generator would cost a step of a program a microsecond
    """Lead the message of an InputError with the place where it arose."""

    __slots__ = ("_where",)

    def __init__(self, where: object) -> None:
        self._where = where

    def __enter__(self) -> None: ...

    def __exit__(self, _kind: object, error: BaseException | None, _trace: object) -> None:
        if isinstance(error, InputError):
            raise InputError(f"{self._where}: {error}") from error
