"""Front of a wave: a film of a transient; from one black cell a trigger wave runs along a row."""

from math import log

import numpy as np

from cnnsim import Template, fixed, trajectory


def main() -> None:
    """Measure the speed of the front, and compare it with the lower bound from theory."""
    wave = Template([[0, 0, 0], [1, 3, 1], [0, 0, 0]], z=3)  # a white cell turns black beside a black one
    start = -np.ones((1, 61))
    start[0, 0] = 1
    film = trajectory(wave, state=start, boundary=fixed(-1), until=40.0, frames=40)
    black = [int((y > 0).sum()) for _, y in film]
    speed = (black[40] - black[10]) / 30
    slowest = 1 / (log(2) + log(5) / 2)  # a cell rests at x = -2 and is driven by 3 as soon as its neighbour is black
    assert slowest < speed < 1.25 * slowest
    print(f"the front goes {speed:.2f} cells in a time constant, at least {slowest:.2f}")


if __name__ == "__main__":
    main()
