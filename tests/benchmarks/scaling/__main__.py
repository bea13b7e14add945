"""Run the scaling study and write its page: ``python -m tests.benchmarks.scaling [-o FOLDER] [--short] [--side N]``."""

import argparse
import os
from pathlib import Path

from tests.benchmarks.accuracy.page import write_page
from tests.benchmarks.scaling import grids, rates

HEAD = """# Scaling: from 2 x 2 taxels to grids that outgrow a machine

`make scaling` measures this page again. Times are of one machine, so look at the ratios. [scale.md](scale.md) says how
to run large grids and sweeps on a laptop or a cluster.
"""


def main() -> None:
    """Measure all sections."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("-o", "--output", type=Path, default=Path("docs"), help="where scaling.md goes")
    parser.add_argument("--short", action="store_true", help="small arrays and few cases, to see that it runs")
    parser.add_argument("--side", type=int, default=4096, help="cells a side of the largest grid")
    given = parser.parse_args()
    os.environ.setdefault("CNNSIM_POCL_PROCESSOR", "auto")  # without it PoCL may build nothing
    if given.short:
        rates.PATIENCE = 0.1
    touch = rates.section(rates.SIDES[:4] if given.short else rates.SIDES)
    sections = [touch, grids.section(1024 if given.short else given.side)]
    write_page(sections, given.output, "scaling", HEAD)
    print(f"{given.output / 'scaling.md'} written")


if __name__ == "__main__":
    main()
