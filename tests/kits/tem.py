"""Short functions that parse a .tem file and return its diagnostics."""

from cnnsim.formats.candy.content import TemFile
from cnnsim.formats.candy.parse import parse_tem
from cnnsim.support import Diagnostics

A = "FEEDBACK:\n0 0 0\n0 1 0\n0 0 0\n"


def parse(text: str) -> tuple[TemFile, Diagnostics]:
    report = Diagnostics("x.tem")
    return parse_tem(text, report), report


def remarks(report: Diagnostics, severity: str) -> list[tuple[int | None, str]]:
    return [(item.line, item.message) for item in report.items if item.severity == severity]
