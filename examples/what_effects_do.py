"""What effects do: one scene with and without the imperfections of a real skin."""

from dataclasses import replace
from pathlib import Path

from tactile import Scene, Settings, open_source, run


def error(scene: Scene) -> float:
    """Return the largest error [N] of the located force, which is 20 mN."""
    errors: list[float] = []
    run(scene, Settings(), [lambda report: errors.append(abs(report.load.F - 0.02) if report.load else 0.0)])
    return max(errors)


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
