"""Edge of a picture: a template of the library on a picture, and the picture written."""

from pathlib import Path

import numpy as np

from cnnsim import run, write_picture


def main(output: Path = Path("edge.png")) -> None:
    """Write the edge of a square ring to ``output``."""
    picture = -np.ones((16, 16))
    picture[3:13, 3:13] = 1
    picture[6:10, 6:10] = -1
    y = run("edge", picture).y
    write_picture(y, output, scale=16)
    assert (y > 0).sum() == 36 + 20  # the rims of 10 x 10 cells and of the 6 x 6 around the hole
    print(f"{(y > 0).sum()} black cells -> {output}")


if __name__ == "__main__":
    main()
