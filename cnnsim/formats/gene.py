"""Reads and writes the 19-number gene ``z b1..b9 a1..a9``: bias, control template and feedback template row by row.

Numbers are separated by blanks, commas or semicolons; ``#`` and ``%`` start comments. A file holds one gene over any
number of lines, or one gene a line. Source: Chua's CNN genes; github.com/MichaelTeti/CNN_EdgeDetection has this order.
"""

import re

import numpy as np

from cnnsim.formats.candy.lines import decode, split
from cnnsim.library.imported import Imported, assume_setting, library_name, plain
from cnnsim.network import AnyTemplate, Template
from cnnsim.support import Diagnostics, Floats, InputError
from cnnsim.support.numbers import number, written

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


def gene(template: AnyTemplate) -> str:
    """Return the gene of a template.

    Raises:
        InputError: a template of radius 2 or more, or one that is not linear.
    """
    template = plain(template, "a gene")
    if template.radius > 1:
        raise InputError(f"template {template.name!r} has radius {template.radius}; a gene holds 3 x 3 only")
    a, b = (_three(matrix) for matrix in (template.A, template.B))
    return " ".join(map(written, [template.z, *b.ravel(), *a.ravel()])) + "\n"


def _three(matrix: Floats) -> Floats:
    """Return the middle 3 x 3 entries, a smaller matrix with a rim of zeros."""
    r = matrix.shape[0] // 2
    return np.pad(matrix, 1) if r == 0 else matrix[r - 1 : r + 2, r - 1 : r + 2]
