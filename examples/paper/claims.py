"""Claims of the paper next to the computed values: one line a claim, in one table.

A script ``figNN_name.py`` has ``compare(folder)``, which returns its claims and draws its figure into the folder if one
is given.
"""

import argparse
from collections.abc import Iterable
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

from cnnsim.support.command_line import print_json
from cnnsim.support.terminal import console


@dataclass(frozen=True)
class Claim:
    """A statement of the paper and the computed value; ``why`` explains a difference."""

    figure: str
    what: str
    paper: str
    ours: str
    agrees: bool
    why: str = ""


def table(claims: Iterable[Claim]) -> None:
    """Print the claims for people."""
    from rich import box  # only for people
    from rich.table import Table  # the same
    from rich.text import Text  # the same

    lines = Table(box=box.SIMPLE_HEAD, show_lines=True)
    for heading, width in (("Fig.", 4), ("what", 32), ("paper", 26), ("ours", 26), ("", 6), ("why", None)):
        lines.add_column(heading, width=width, overflow="fold")
    for claim in claims:
        verdict = Text("agrees", "green") if claim.agrees else Text("not so", "red")
        lines.add_row(claim.figure, claim.what, claim.paper, claim.ours, verdict, claim.why)
    console().print(lines)


def as_json(claims: Iterable[Claim]) -> None:
    """Print the claims for a machine."""
    print_json([asdict(claim) | {"agrees": bool(claim.agrees)} for claim in claims])  # NumPy's bool is not JSON


def arguments(parser: argparse.ArgumentParser) -> argparse.Namespace:
    """Parse the parser's own arguments, ``-o FOLDER`` (created if missing; None by default) and ``--json``."""
    parser.add_argument("-o", "--output", type=Path, help="folder for the figures")
    parser.add_argument("--json", action="store_true", help="print JSON for a machine to read")
    given = parser.parse_args()
    if given.output is not None:
        given.output.mkdir(parents=True, exist_ok=True)
    return given


def study(
    what: str | None, rows: list[dict[str, Any]], cells: Iterable[list[str]], headings: Iterable[str]
) -> Path | None:
    """Print the rows of a study, as JSON or as a table of ``cells``; return the folder for its figure, or None."""
    from rich import box  # only for people
    from rich.table import Table  # the same

    given = arguments(argparse.ArgumentParser(description=what))
    if given.json:
        print_json(rows)
    else:
        shown = Table(box=box.SIMPLE_HEAD)
        for heading in headings:
            shown.add_column(heading, justify="left" if heading in ("skin", "brings back") else "right")
        for line in cells:
            shown.add_row(*line)
        console(170).print(shown)
    folder: Path | None = given.output
    return folder
