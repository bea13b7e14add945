"""Reader of CSV tables by people: labels of recordings, weights of calibrations."""

import csv
from collections.abc import Sequence
from io import StringIO
from pathlib import Path

from cnnsim.support import InputError
from cnnsim.support.limits import LABELS, check_file, reason


def read_lines(path: Path, content: str = "labels") -> tuple[list[dict[str, str]], Sequence[str]]:
    """Return the rows of a table by column, without lines that start with #, and the names of its columns.

    Raises:
        InputError: a missing file, or one that is not a text table.
    """
    try:
        check_file(path, f"table of {content}", LABELS)
        lines = StringIO(path.read_text(encoding="utf-8-sig"))
        reader = csv.DictReader(line for line in lines if not line.startswith("#"))
        return list(reader), reader.fieldnames or ()
    except (OSError, UnicodeDecodeError, csv.Error) as error:
        raise InputError(f"{path}: cannot be read as a table of {content}: {reason(error)}") from error
