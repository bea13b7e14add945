"""Reads the template text of CNNSim: a section's letter, then its values.

Grammar: ``A`` nine numbers, ``B`` nine numbers, ``Z`` one number, ``C`` (or ``Boundary``) then ``Constant v``,
``ZeroFlux`` or ``Periodic``; line breaks and blanks are free, sections come in any order, a missing one is zero.
Source: the template files of github.com/H2CO3/CNNSim.
"""

from cnnsim.formats.candy.header import read_boundary
from cnnsim.formats.candy.lines import decode
from cnnsim.formats.numbers import number
from cnnsim.library.imported import Imported, assume_setting, library_name
from cnnsim.network import Template
from cnnsim.support import Diagnostics, InputError

_HEADS = ("A", "B", "Z", "C", "BOUNDARY")


def read_cnnsim(data: bytes, name: str, report: Diagnostics) -> list[Imported]:
    """Return the one template of a file, none if there is an error."""
    pieces = [(word, k) for k, row in enumerate(decode(data, report).split("\n"), start=1) for word in row.split()]
    sections: dict[str, list[tuple[str, int]]] = {}
    current = ""
    for word, line in pieces:
        if word.upper().rstrip(":") in _HEADS:
            current = word.upper().rstrip(":").replace("BOUNDARY", "C")
            if current in sections:
                report.error(line, f"a second section {current}")
            sections[current] = []
        elif current:
            sections[current].append((word, line))
        else:
            report.error(line, f"{word[:40]!r} before the first section; A, B, Z or C wanted")
            return []
    if not {"A", "B"} & sections.keys():
        report.error(None, "no section A and no section B: this is no CNNSim template")
    a, b, z = (_numbers(sections, head, count, report) for head, count in (("A", 9), ("B", 9), ("Z", 1)))
    if report.failed:
        return []
    name = library_name(name)
    template = Template([a[:3], a[3:6], a[6:]], [b[:3], b[3:6], b[6:]], z[0], name)
    imported = Imported(
        name, f"CNNSim template {name}; the source does not say what it does.", f"Imported from {report.file}", template
    )
    boundary = None
    if "C" in sections:
        words = sections["C"]
        text = words[0][0] + "".join(f"({word})" for word, _ in words[1:2]) if words else ""
        boundary = read_boundary(text, report, words[0][1] if words else None)
    return [assume_setting(imported, report, boundary)]


def _numbers(sections: dict[str, list[tuple[str, int]]], head: str, count: int, report: Diagnostics) -> list[float]:
    values = []
    for word, line in sections.get(head, []):
        try:
            values.append(number(word))
        except InputError as error:
            report.error(line, f"section {head}: {error}")
    if head in sections and len(values) != count:
        report.error(
            sections[head][-1][1] if sections[head] else None, f"section {head}: {len(values)} numbers, {count} wanted"
        )
    return values if head in sections else [0.0] * count
