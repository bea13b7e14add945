"""Names that files give and that become names of files: letters, digits, - and _."""

import re

from cnnsim.support.errors import InputError

LONGEST = 100
"""Characters of a name: with a folder's and a suffix it still is a file's name everywhere."""
_NAME = re.compile(rf"[A-Za-z0-9_][A-Za-z0-9_-]{{0,{LONGEST - 1}}}", re.ASCII)


def check_name(name: str, what: str) -> str:
    """Return a name.

    Raises:
        InputError: it has other characters than letters, digits, - and _, begins with -, is empty or too long.
    """
    if not _NAME.fullmatch(name):
        raise InputError(
            f"{what} {name[: LONGEST + 1]!r}; letters, digits, - and _ wanted, not - first, {LONGEST} at most"
        )
    return name
