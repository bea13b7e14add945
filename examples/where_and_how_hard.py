"""Where and how hard: a load is located from strains, and compared with the load of the scene."""

from pathlib import Path

import numpy as np

import tactile

SCENE = Path(__file__).parent / "scenes" / "grip.toml"


def main() -> None:
    """Locate both fingers' loads while the object is held."""
    loads = tactile.run(SCENE).loads["left"]
    held = int(np.searchsorted(loads.t, 2.5))
    x, y, *forces = (float(column[held]) for column in (loads.x, loads.y, loads.Q, loads.R, loads.F))
    assert np.allclose((x, y), (0.20e-3, -0.30e-3), atol=1e-6)  # [m]
    assert np.allclose(forces, (0.02, 0.30, 0.60), atol=1e-3)  # Q, R, F [N]
    print(f"left: ({x * 1e3:.4f}, {y * 1e3:.4f}) mm, {forces[0]:.4f} {forces[1]:.4f} {forces[2]:.4f} N")


if __name__ == "__main__":
    main()
