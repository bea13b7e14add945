"""Measure what accuracy costs and write the page: ``python -m tests.benchmarks.accuracy [-o FOLDER] [--cases N]``."""

import argparse
import os
from collections.abc import Callable
from pathlib import Path

from tests.benchmarks.accuracy import bump, effects, halfspace, inverse, library_signs, transients
from tests.benchmarks.accuracy.page import write_page
from tests.benchmarks.accuracy.section import Section


def main() -> None:
    """Measure all sections; a new section is a module in this folder, called here."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("-o", "--output", type=Path, default=Path("docs"), help="where accuracy.md goes")
    parser.add_argument("--cases", type=int, default=400, help="random cases on which accuracy= is tried")
    parser.add_argument("--scenes", type=int, default=300, help='random scenes on which effects = "auto" is tried')
    parser.add_argument("--only", nargs="+", help="measure only these sections; the others are kept")
    given = parser.parse_args()
    os.environ.setdefault("CNNSIM_POCL_PROCESSOR", "auto")  # without it PoCL may build nothing
    sections: dict[str, Callable[[], Section]] = {
        "transients": lambda: transients.section(given.cases), "library": library_signs.section,
        "halfspace": halfspace.section, "bump": bump.section, "inverse": inverse.section,
        "effects": lambda: effects.section(given.scenes),
    }  # fmt: skip
    measured = [sections[stem]() for stem in given.only or sections]
    write_page(measured, given.output, order=list(sections))
    print(f"{given.output / 'accuracy.md'} written")


if __name__ == "__main__":
    main()
