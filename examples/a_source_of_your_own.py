"""A source of your own: frames of force sensors that are pressed, then pushed to the right."""

from collections.abc import Iterator

import numpy as np

from tactile import Frame, TaxelArray, run


class Push:
    """2 x 2 force sensors at 100 frames/s: 1 N each from 0.1 s on, 0.5 N to the right from 0.2 s on."""

    title, modulus, frames, arrays = "a push", None, 30, (TaxelArray("pad", 2, 2, 4e-3, 0.0, quantity="force"),)

    def __iter__(self) -> Iterator[Frame]:
        for n in range(30):  # values (rows, cols, 3): shear_x, shear_y, normal [N]
            yield Frame(0, n / 100, n, np.tile([0.5 * (n >= 20), 0, n >= 10], (2, 2, 1)), np.ones((2, 2), bool))


def main() -> None:
    """Print what happened."""
    events = run(Push()).events
    print(events)
    assert 0.09 <= events[0].t <= 0.1 and events[-1].words == "tangential load +x"


if __name__ == "__main__":
    main()
