"""All figures of the paper in one table: ``python -m examples.paper [-o FOLDER] [--json]``."""

import importlib
import sys
from collections.abc import Callable
from pathlib import Path

from cnnsim.support.command_line import watched
from examples.paper.claims import Claim, arguments, as_json, table

SCRIPTS = sorted(path.stem for path in Path(__file__).parent.glob("fig[0-9][0-9]_*.py"))


def main() -> None:
    """Run every script that is there."""
    given = arguments(__doc__)
    claims: list[Claim] = []
    for name in watched(SCRIPTS, "figures"):
        try:
            compare: Callable[[Path | None], list[Claim]] = importlib.import_module(f"examples.paper.{name}").compare
        except SystemExit as missing:
            print(f"left out: {name}: {missing}", file=sys.stderr)
        else:
            claims += compare(given.output)
    (as_json if given.json else table)(claims)


if __name__ == "__main__":
    main()
