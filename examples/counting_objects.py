"""Counting objects: an analogic program by name, and one machine that runs it on many pictures."""

import numpy as np

from cnnsim import UniversalMachine, load_program, run_program


def main() -> None:
    """Count black squares on a grid of 40 x 40 cells."""
    picture = -np.ones((40, 40))
    for row, col in [(2, 2), (2, 20), (15, 8), (30, 30)]:
        picture[row : row + 6, col : col + 6] = 1
    assert run_program("count-objects", picture=picture)["objects"] == 4
    machine, program = UniversalMachine(), load_program("count-objects")
    counts = [machine.run(program, picture=picture[:rows])["objects"] for rows in (10, 25, 40)]
    assert counts == [2, 3, 4]
    print(f"{counts} objects in the first 10, 25 and 40 rows")


if __name__ == "__main__":
    main()
