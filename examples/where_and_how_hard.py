"""Where and how hard: a load is located from strains, and compared with the load of the scene."""

from pathlib import Path

from tactile import FrameReport, Load, Settings, open_source, run

SCENE = Path(__file__).parent / "scenes" / "grip.toml"


def main() -> None:
    """Locate both fingers' loads while the object is held."""
    held: dict[str, Load] = {}

    def keep(report: FrameReport) -> None:
        if report.load is not None and abs(report.frame.t - 2.5) < 1e-9:
            held[report.array.name] = report.load

    run(open_source(SCENE), Settings(), [keep])
    load = held["left"]
    assert max(abs(load.x - 0.20e-3), abs(load.y + 0.30e-3)) < 1e-6  # [m]
    assert max(abs(load.Q - 0.02), abs(load.R - 0.30), abs(load.F - 0.60)) < 1e-3  # [N]
    print(f"left: ({load.x * 1e3:.4f}, {load.y * 1e3:.4f}) mm, {load.Q:.4f} {load.R:.4f} {load.F:.4f} N")


if __name__ == "__main__":
    main()
