"""The command that scores recordings against labels, and simulated grasps against their closed form."""

from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from cnnsim.support import InputError
from cnnsim.support.command_line import examples, print_json, watched
from cnnsim.support.echo import echo
from tactile.cli.options import check_thresholds, detection

if TYPE_CHECKING:
    from tactile.core.source import Source
    from tactile.settings import Settings

HALVES = ("all", "tune", "report")


@click.command(
    epilog=examples(
        "tactile score grasps/ --labels grasps/labels.csv", "tactile score . --labels l.csv --half report --json",
        "tactile score --grasps 20 --idle-minutes 1",
    )
)  # fmt: skip
@click.argument("folder", type=click.Path(path_type=Path), required=False)
@click.option("--labels", type=click.Path(path_type=Path), help="CSV: recording, sensor, times [s].")
@click.option("--grasps", type=click.IntRange(0), default=0, help="So many simulated grasps with known onsets.")
@click.option("--idle-minutes", type=click.FloatRange(0), default=0.0, help="Minutes of noise in which nothing is.")
@click.option("--half", type=click.Choice(HALVES), default="all", help="Every other recording and grasp.")
@click.option("--window-ms", type=float, default=50.0, show_default=True, help="How near an event has to begin.")
@detection
@click.option("--json", "as_json", is_flag=True, help="Print JSON for a machine to read.")
def score(
    folder: Path | None, labels: Path | None, grasps: int, idle_minutes: float, half: str, window_ms: float,
    as_json: bool, **chosen: Any,
) -> None:  # fmt: skip
    """Compare events with what is known, beside plain thresholds: of the recordings in FOLDER, of simulated grasps.

    Columns of LABELS: recording, sensor (0, 1, ...), and those that are known of contact_s, release_s,
    tangential_onset_s and gross_slip_s; peak_s and open_s bound a hold, flag_on_s is the device's own word. Grasps slip
    from the rim inwards, under noise of 1.1 mN (shear) and 3.6 mN (normal) and one taxel of 50 mN.
    """
    if (folder is None) != (labels is None):
        raise click.UsageError("FOLDER without --labels, or --labels without FOLDER; both wanted")
    if folder is None and not grasps and not idle_minutes:
        raise click.UsageError("nothing to score; FOLDER and --labels, --grasps or --idle-minutes wanted")
    from tactile.core.source import provenance  # the machine is loaded only when it runs
    from tactile.settings import PipelineOptions  # the same

    check_thresholds(chosen)
    found: dict[str, Any] = {}

    def settings(source: "Source") -> "Settings":
        options = PipelineOptions(**chosen, tare="auto" if provenance(source).untared else "off")
        return options.settings(source.arrays, None)

    if folder is not None and labels is not None:
        from tactile.score.labels import read_labels  # the same
        from tactile.score.measure import score as measure  # the same
        from tactile.sources import open_source  # the same

        def opened(path: Path) -> tuple["Source", "Settings"]:
            source = open_source(path)
            return source, settings(source)

        known = read_labels(labels)
        kept = set(_half(sorted({one.recording for one in known}), half))
        known = [one for one in known if one.recording in kept]
        found = measure(
            folder, known, opened, window_ms * 1e-3, lambda names: watched(names, "recordings", len(names))
        ).plain()
    if grasps or idle_minutes:
        from tactile.score.simulated import score_grasps  # the same

        seeds = _half(list(range(grasps)), half)
        simulated = score_grasps(watched(seeds, "grasps", len(seeds)), settings, idle_minutes, window_ms * 1e-3)
        found["simulated"] = simulated.plain()
    if as_json:
        print_json(found)
        return
    simulated_figures = found.pop("simulated", None)
    _print(found)
    if simulated_figures is not None:
        echo("simulated grasps:")
        _print(simulated_figures)


def _half(items: list[Any], half: str) -> list[Any]:
    if half != "all" and len(items) == 1:
        raise InputError(f"--half {half}: {items[0]} is all there is; two or more recordings or grasps wanted")
    return items if half == "all" else items[HALVES.index(half) - 1 :: 2]


def _print(found: dict[str, Any]) -> None:
    for kind, figures in found.pop("kinds", {}).items():
        errors = figures["onset_error_s"]
        onset = (
            "" if errors is None else ", onset " + " ".join(f"{1e3 * one:+.1f}" for one in errors) + " ms (5 50 95 %)"
        )
        ratios = f"precision {_ratio(figures['precision'])}, recall {_ratio(figures['recall'])}"
        echo(
            f"{kind:<28} {ratios}, {figures['hit']} right, {figures['false']} false, {figures['missed']} missed{onset}"
        )
    for name, value in found.items():
        if value not in (None, {}):
            echo(f"{name.replace('_', ' ')}: {value}")


def _ratio(value: float | None) -> str:
    return "-" if value is None else f"{value:.3f}"
