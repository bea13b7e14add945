"""Read the 19-number gene ``z b1..b9 a1..a9``: bias, control template and feedback template row by row.

Numbers are separated by blanks, commas or semicolons; ``#`` and ``%`` start comments. A file holds one gene over any
number of lines, or one gene a line. Source: Chua's CNN genes; github.com/MichaelTeti/CNN_EdgeDetection has this order.
"""

import re

import numpy as np

from cnnsim.formats.candy.lines import decode, split
from cnnsim.formats.numbers import number
from cnnsim.library.imported import Imported, assume_setting, library_name
from cnnsim.network import Template
from cnnsim.support import Diagnostics, InputError

LENGTH = 19


def read_gene(data: bytes, name: str, report: Diagnostics) -> list[Imported]:
    """Return a template for each gene."""
    rows: list[list[float]] = []
    for line, row in split(decode(data, report), report):
        words = re.split(r"[\s,;]+", re.split("[#%]", row, maxsplit=1)[0].strip())
        try:
            rows.append([number(word) for word in words if word])
        except InputError as error:
            report.error(line, str(error))
    rows = [row for row in rows if row]
    if not rows or any(len(row) != LENGTH for row in rows):
        rows = [[value for row in rows for value in row]]
    if len(rows[0]) != LENGTH:
        report.error(
            None, f"{len(rows[0])} numbers; {LENGTH} wanted (z, b1 to b9, a1 to a9), or {LENGTH} on every line"
        )
    if report.failed:
        return []
    names = [library_name(name if len(rows) == 1 else f"{name}-{k}") for k in range(1, len(rows) + 1)]
    return [_imported(row, each, report) for row, each in zip(rows, names, strict=True)]


def _imported(gene: list[float], name: str, report: Diagnostics) -> Imported:
    b, a = (np.array(part).reshape(3, 3) for part in (gene[1:10], gene[10:]))
    template = Template(a, b, gene[0], name)
    summary = f"The gene {name}; the source does not say what it does."
    return assume_setting(Imported(name, summary, f"Imported from {report.file}", template), report)
