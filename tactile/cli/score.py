"""The command that scores recordings against labels."""

from pathlib import Path
from typing import Any

import click

from cnnsim.support.command_line import examples, print_json
from cnnsim.support.echo import echo
from tactile.cli.options import check_thresholds, detection


@click.command(
    epilog=examples("tactile score grasps/ --labels grasps/labels.csv", "tactile score . --labels l.csv --json")
)
@click.argument("folder", type=click.Path(path_type=Path))
@click.option("--labels", type=click.Path(path_type=Path), required=True, help="CSV: recording, sensor, times [s].")
@click.option("--window-ms", type=float, default=50.0, show_default=True, help="How near an event has to begin.")
@detection
@click.option("--json", "as_json", is_flag=True, help="Print JSON for a machine to read.")
def score(folder: Path, labels: Path, window_ms: float, as_json: bool, **chosen: Any) -> None:
    """Compare the events of the recordings in FOLDER with labels, beside plain thresholds.

    Columns of LABELS: recording, sensor (0, 1, ...), and those that are known of contact_s, release_s,
    tangential_onset_s and gross_slip_s; peak_s and open_s bound a hold, flag_on_s is the device's own word.
    """
    from tactile.core.source import Source, provenance  # the machine is loaded only when it runs
    from tactile.score.labels import read_labels  # the same
    from tactile.score.measure import score as measure  # the same
    from tactile.settings import PipelineOptions, Settings  # the same
    from tactile.sources import open_source  # the same

    check_thresholds(chosen)

    def opened(path: Path) -> tuple[Source, Settings]:
        source = open_source(path)
        options = PipelineOptions(**chosen, tare="auto" if provenance(source).untared else "off")
        return source, options.settings(source.arrays, None)

    plain = measure(folder, read_labels(labels), opened, window_ms * 1e-3).plain()
    if as_json:
        print_json(plain)
        return
    for kind, figures in plain.pop("kinds").items():
        errors = figures["onset_error_s"]
        onset = (
            "" if errors is None else ", onset " + " ".join(f"{1e3 * one:+.1f}" for one in errors) + " ms (5 50 95 %)"
        )
        ratios = f"precision {_ratio(figures['precision'])}, recall {_ratio(figures['recall'])}"
        echo(
            f"{kind:<28} {ratios}, {figures['hit']} right, {figures['false']} false, {figures['missed']} missed{onset}"
        )
    for name, value in plain.items():
        if value not in (None, {}):
            echo(f"{name.replace('_', ' ')}: {value}")


def _ratio(value: float | None) -> str:
    return "-" if value is None else f"{value:.3f}"
