"""Measure what accuracy costs and write the page: ``python -m tests.benchmarks.accuracy [-o FOLDER] [--cases N]``."""

import argparse
import os
from pathlib import Path

from tests.benchmarks.accuracy import bump, effects, halfspace, inverse, touch, transients
from tests.benchmarks.accuracy.page import write_page


def main() -> None:
    """Measure all sections; a new one is a module beside `transients`, called here."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("-o", "--output", type=Path, default=Path("docs"), help="where accuracy.md goes")
    parser.add_argument("--cases", type=int, default=400, help="random cases on which accuracy= is tried")
    parser.add_argument("--scenes", type=int, default=300, help='random scenes on which effects = "auto" is tried')
    given = parser.parse_args()
    os.environ.setdefault("CNNSIM_POCL_PROCESSOR", "auto")  # without it PoCL may build nothing
    sections = [
        transients.section(given.cases), halfspace.section(), bump.section(), inverse.section(),
        effects.section(given.scenes), touch.section(),
    ]  # fmt: skip
    write_page(sections, given.output)
    print(f"{given.output / 'accuracy.md'} written")


if __name__ == "__main__":
    main()
