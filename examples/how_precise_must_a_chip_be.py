"""The share of wrong cells of EDGE under errors of its entries, few bits and noise, drawn as curves."""

import argparse
from pathlib import Path

from cnnsim import library
from cnnsim.prototyping.robust.report import draw_robustness
from cnnsim.prototyping.robust.robust import measure


def main(output: Path) -> None:
    """Write the curves to ``output``."""
    draw_robustness(measure(library.load("edge"), draws=20), output)


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("-o", "--output", type=Path, default=Path("robust.png"), help="picture to write")
    main(parser.parse_args().output)
