"""Lines of a label file: a CSV file of what people know of recordings."""

import csv
from collections.abc import Sequence
from pathlib import Path

from cnnsim.support import InputError


def read_lines(path: Path) -> tuple[list[dict[str, str]], Sequence[str]]:
    """Return the lines of a label file by column, and the names of its columns.

    Raises:
        InputError: no such file, or none that is read as text.
    """
    try:
        with path.open(encoding="utf-8", newline="") as file:
            reader = csv.DictReader(file)
            return list(reader), reader.fieldnames or ()
    except (OSError, UnicodeDecodeError, csv.Error) as error:
        why = error.strerror if isinstance(error, OSError) else str(error)
        raise InputError(f"{path}: cannot be read as labels: {why}") from error
