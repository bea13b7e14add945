"""A scene in Python: a ball is pressed on a noisy skin, and located to 50 micrometres."""

import numpy as np

from tactile import Indenter, MovingContact, Scene, TaxelArray, make_effect, run


def main() -> None:
    """Locate the ball while it is held."""
    pad = TaxelArray("pad", rows=4, cols=4, pitch=1.5e-3, depth=1.5e-3)  # [m]
    path = [(0.1, 1e-3, 0, 0, 0, 0), (0.3, 1e-3, 0, 0, 0, 0.5), (0.5, 1e-3, 0, 0.1, 0, 0.5)]  # t, x, y, Q, R, F
    ball = MovingContact(0, Indenter("sphere", radius=2e-3), path)
    noise = make_effect("read_noise", rms=1e-4)
    scene = Scene("a ball", rate=200, duration=0.5, modulus=2.4e6, arrays=[pad], contacts=[ball], effects=[noise])
    loads = run(scene).loads["pad"]
    true = scene.loads_at(0, loads.t)[:, 0]  # x, y, Q, R, F of each frame
    errors = np.hypot(loads.x - true[:, 0], loads.y - true[:, 1])[loads.t >= 0.4]
    print(f"{scene}: off by {np.median(errors) * 1e6:.2g} um")
    assert np.median(errors) < 5e-5  # [m]


if __name__ == "__main__":
    main()
