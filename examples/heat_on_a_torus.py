"""Heat on a torus: a template of your own, against the decay that the equation has in closed form."""

import numpy as np

from cnnsim import PERIODIC, Template, run_transient


def main() -> None:
    """Let one cosine of temperature decay for two time constants."""
    heat = Template([[0.1, 0.15, 0.1], [0.15, 0, 0.15], [0.1, 0.15, 0.1]])
    _, cols = np.indices((8, 32))
    wave = 0.9 * np.cos(2 * np.pi * cols / 32)
    end = run_transient(heat, state=wave, boundary=PERIODIC, duration=2.0, scheme="rk4", dtype="float64").x
    gain = 0.3 + 0.7 * np.cos(2 * np.pi / 32)  # A applied to the wave: 0.3 in its own column, 0.35 on either side
    assert np.abs(end - wave * np.exp((gain - 1) * 2.0)).max() < 1e-6
    print(f"the crest falls from 0.9 to {end.max():.6f}")


if __name__ == "__main__":
    main()
