"""Reader of label files: CSV tables of known events of recordings."""

import csv
from collections.abc import Sequence
from io import StringIO
from pathlib import Path

from cnnsim.support import InputError
from cnnsim.support.limits import reason


def read_lines(path: Path) -> tuple[list[dict[str, str]], Sequence[str]]:
    """Return the rows of a label file by column, and the names of its columns.

    Raises:
        InputError: a missing file, or one that is not a text table.
    """
    try:
        reader = csv.DictReader(StringIO(path.read_text(encoding="utf-8-sig")))
        return list(reader), reader.fieldnames or ()
    except (OSError, UnicodeDecodeError, csv.Error) as error:
        raise InputError(f"{path}: cannot be read as a table of labels: {reason(error)}") from error
