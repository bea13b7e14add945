"""Two layers that turn: cells of two layers drive each other, so that their states rotate."""

import numpy as np

from cnnsim import LayeredTemplate, Template, Term, run_transient


def main() -> None:
    """Integrate x1' = -w x2, x2' = w x1 for one full turn in the linear range of the cells."""
    w = 2.0
    first = Template([[1]], terms=[Term([[-w]], "y_kl", layer=1)])
    second = Template([[1]], terms=[Term([[w]], "y_kl", layer=0)])
    network = LayeredTemplate([first, second])
    start = np.array([[[0.8, 0.3]], [[0.0, 0.4]]])  # (layers, rows, cols)
    quarter, turn = (
        run_transient(network, state=start, duration=turns * 2 * np.pi / w, scheme="rk4", step=0.005, dtype="float64").x
        for turns in (0.25, 1.0)
    )
    assert np.abs(quarter - [-start[1], start[0]]).max() < 1e-6
    assert np.abs(turn - start).max() < 1e-6
    print(f"after one turn {np.abs(turn - start).max():.1e} from the start")


if __name__ == "__main__":
    main()
