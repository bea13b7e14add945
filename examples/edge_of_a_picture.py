"""A library template on a picture: read, run, write."""

import argparse
from pathlib import Path

from cnnsim import library, run, write_picture


def main(output: Path) -> None:
    """Write the edge of a drawn ring to ``output``."""
    picture = library.load("hole-filler").examples[0].input
    assert picture is not None
    result = run("edge", picture)
    write_picture(result.y, output, scale=16)


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("-o", "--output", type=Path, default=Path("edge.png"), help="picture to write")
    main(parser.parse_args().output)
