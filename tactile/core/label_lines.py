"""Lines of a label file: a CSV file of what people know of recordings."""

import csv
from collections.abc import Sequence
from io import StringIO
from pathlib import Path

from cnnsim.support import InputError
from cnnsim.support.limits import reason


def read_lines(path: Path) -> tuple[list[dict[str, str]], Sequence[str]]:
    """Return the lines of a label file by column, and the names of its columns.

    Raises:
        InputError: no such file, or none that is read as text.
    """
    try:
        reader = csv.DictReader(StringIO(path.read_text(encoding="utf-8-sig")))
        return list(reader), reader.fieldnames or ()
    except (OSError, UnicodeDecodeError, csv.Error) as error:
        raise InputError(f"{path}: cannot be read as a table of labels: {reason(error)}") from error
