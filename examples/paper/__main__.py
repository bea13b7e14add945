"""Figures of the paper in one table: ``python -m examples.paper [NUMBER ...] [-o FOLDER] [--json]``."""

import argparse
import importlib
import sys
from collections.abc import Callable
from pathlib import Path

from cnnsim.support.command_line import watched
from examples.paper.claims import Claim, arguments, as_json, table

SCRIPTS = sorted(path.stem for path in Path(__file__).parent.glob("fig[0-9][0-9]_*.py"))


def main() -> None:
    """Run the scripts of the given figures, or all."""
    parser, numbers = argparse.ArgumentParser(description=__doc__), [int(name[3:5]) for name in SCRIPTS]
    parser.add_argument("figure", type=int, nargs="*", help=f"number of a figure: {numbers}; default: all")
    given = arguments(parser)
    if unknown := {*given.figure} - {*numbers}:
        parser.error(f"no figure {min(unknown)}; one of {numbers} expected")
    claims: list[Claim] = []
    for name in watched([name for name in SCRIPTS if int(name[3:5]) in (given.figure or numbers)], "figures"):
        try:
            compare: Callable[[Path | None], list[Claim]] = importlib.import_module(f"examples.paper.{name}").compare
        except SystemExit as missing:
            print(f"left out: {name}: {missing}", file=sys.stderr)
        else:
            claims += compare(given.output)
    (as_json if given.json else table)(claims)


if __name__ == "__main__":
    main()
