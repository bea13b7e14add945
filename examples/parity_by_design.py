"""A rule that no single template can do, the parity of a 3 x 3 window: designed, written, and run as a program."""

import argparse
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np

from cnnsim import fixed, write_picture
from cnnsim.program.file import load_program
from cnnsim.program.machine import UniversalMachine
from cnnsim.prototyping.design.decompose import design_rule
from cnnsim.prototyping.design.expression import parse_rule
from cnnsim.prototyping.design.files import write_design


def main(output: Path) -> None:
    """Write the parity of a drawn disc to ``output``."""
    found = design_rule(parse_rule("all9 % 2 == 1"))  # five templates, each starting from the negative of the last
    row, col = np.mgrid[:33, :33] - 16
    disc = np.where(row**2 + col**2 < 140, 1.0, -1.0)
    with TemporaryDirectory() as folder:
        program = load_program(write_design(found, "parity", fixed(-1), Path(folder))[-1])
    result = UniversalMachine().run(program, picture=disc)["result"]
    write_picture(result, output, scale=8)


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("-o", "--output", type=Path, default=Path("parity.png"), help="picture to write")
    main(parser.parse_args().output)
