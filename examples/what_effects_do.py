"""What effects do: one scene with and without the imperfections of a real skin."""

from dataclasses import replace
from pathlib import Path

import numpy as np

from tactile import Scene, open_source, run


def error(scene: Scene) -> float:
    """Return the largest error [N] of the located force, which is 20 mN."""
    (loads,) = run(scene).loads.values()
    return float(np.nanmax(np.abs(loads.F - 0.02)))


def main() -> None:
    """Draw a needle over a taxel."""
    scene = open_source(Path(__file__).parent / "scenes" / "needle.toml")
    assert isinstance(scene, Scene)
    real, ideal = error(scene), error(replace(scene, effects=()))
    assert ideal < 1e-9
    assert 1e-3 < real < 20e-3
    print(f"off by {ideal:.1e} N without and by {real:.1e} N with {len(scene.effects)} effects")


if __name__ == "__main__":
    main()
