"""Command `score`: recordings and sequences against labels, simulated grasps against closed forms."""

from collections.abc import Iterable
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from cnnsim.support import InputError
from cnnsim.support.command_line import examples, print_json, watched
from cnnsim.support.terminal import echo
from tactile.cli.options import ARRAY, FILE, JSON, LAYOUT, Finite, check_thresholds, detection
from tactile.core.source import Source, provenance
from tactile.settings import PipelineOptions, Settings
from tactile.sources import layout_of

if TYPE_CHECKING:  # imported when used
    from tactile.score.labels import LabelledSource
    from tactile.score.robustness import Robustness

HALVES = ("all", "tune", "report")
FEW = 0.5
"""Share of contact frames explained by located loads, below which the array description is probably wrong."""


@click.command(
    epilog=examples(
        "tactile score grasps/ --labels grasps/labels.csv", "tactile score . --labels l.csv --half report --json",
        "tactile score --grasps 20 --from-seed 200 --idle-minutes 1",
        "tactile score slips.npz --array board.toml --gain 0.25 --gain 4",
        "tactile score grasps/ --labels grasps/labels.csv --perturb",
        "tactile score --grasps 10 --perturb steps,rotation",
    )
)  # fmt: skip
@click.argument("recordings", type=FILE, required=False)
@click.option("--labels", type=FILE, help="CSV: recording, sensor, times [s].")
@click.option(
    "--grasps", type=click.IntRange(0, 1_000_000), default=0, help="Number of simulated grasps with known onsets."
)
@click.option("--from-seed", type=click.IntRange(0), default=0, show_default=True, help="Seed of the first grasp.")
@click.option("--idle-minutes", type=Finite(0, 10_000), default=0.0, help="Minutes of noise without any contact.")
@click.option("--half", type=click.Choice(HALVES), default="all", help="Every other recording and grasp.")
@click.option(
    "--window-ms",
    type=Finite(0, min_open=True),
    default=50.0,
    show_default=True,
    help="Largest error of an onset.",
)
@ARRAY
@click.option("--gain", "gains", type=Finite(), multiple=True, help="Of sequences: factor on the readings; again.")
@click.option("--kind", "kinds", multiple=True, help="Of sequences: kind that is a slip [all of pulling and slipping].")
@click.option(
    "--rate", type=Finite(0, min_open=True), help="Of sequences: readings a second, if the file has no rate_hz."
)
@click.option(
    "--perturb",
    is_flag=False,
    flag_value="all",
    help="Score perturbed readings: all, or groups such as steps,rotation.",
)
@LAYOUT
@detection
@JSON
def score(
    recordings: Path | None, labels: Path | None, grasps: int, from_seed: int, idle_minutes: float, half: str,
    window_ms: float, as_json: bool, array: Path | None, gains: tuple[float, ...], kinds: tuple[str, ...],
    rate: float | None, perturb: str | None, layout: Path | None, **chosen: Any,
) -> None:  # fmt: skip
    """Compare events with labels or with simulated grasps.

    Plain thresholds are compared as well.

    RECORDINGS is a folder with --labels, or an NPZ file of sequences of a device's readings with --array.

    --perturb scores the same readings with converter steps, other rates and tempos, lost frames, noise, drift, a frozen
    taxel, gains and rotated axes: precision, recall and false shear events a minute of each.

    Columns of LABELS: recording, sensor (0, 1, ...), and the known ones of contact_s, release_s,
    tangential_onset_s and gross_slip_s; peak_s and open_s bound a hold, flag_on_s is the device's own slip flag.
    Grasps slip from the rim inwards, under noise of 1.1 mN (shear) and 3.6 mN (normal) and one taxel of 50 mN.

    Sequences: signal (sequences, frames, channels: boards, chips, x y z), slip (sequences,) yes or no, rate_hz, and
    onset_s (sequences,) where it is known; else the onset is where the signal begins to change.
    """
    sequenced = recordings is not None and array is not None
    if (recordings is None) != (labels is None and array is None) or (labels is not None and array is not None):
        raise click.UsageError("a folder and --labels, or a file of sequences and --array, wanted")
    if not sequenced and (gains or kinds or rate is not None):
        raise click.UsageError("--gain, --kind and --rate are of sequences; a file of them and --array wanted")
    if recordings is None and not grasps and not idle_minutes:
        raise click.UsageError("nothing to score; a folder and --labels, --grasps or --idle-minutes wanted")
    if perturb and (sequenced or idle_minutes):
        raise click.UsageError("--perturb is of labelled recordings and of --grasps")
    check_thresholds(chosen)
    found: dict[str, Any] = {}

    def settings(source: Source) -> Settings:
        options = PipelineOptions(**chosen, tare="auto" if provenance(source).untared else "off")
        return options.settings(source)

    sources: list[Iterable[LabelledSource]] = []
    window = window_ms * 1e-3
    if recordings is not None and labels is not None:
        from tactile.score.labels import read_labels  # imported when used
        from tactile.score.measure import labelled_sources  # the same
        from tactile.score.measure import score as measure  # the same

        known = read_labels(labels)
        kept = set(_half(sorted({one.recording for one in known}), half))
        known = [one for one in known if one.recording in kept]
        watch = iter if perturb else lambda names: watched(names, "recordings", len(names))
        missing, opened = labelled_sources(recordings, known, layout_of(recordings, layout), watch)
        if missing:
            echo(f"{recordings}: no recording of the labels {', '.join(missing)}", err=True)
        if perturb:
            sources.append(opened)
        else:
            found = measure(opened, settings, window, missing).plain()
            if found["fingers_untared"]:
                echo(f"never still enough for a tare, without events: {', '.join(found['fingers_untared'])}", err=True)
    if recordings is not None and array is not None:
        from tactile.score.sequences import KINDS, read_sequences, score_sequences  # the same
        from tactile.wire.description_file import read_description  # the same

        described = read_description(array)
        found["sequences"] = score_sequences(
            read_sequences(recordings, described, rate), described, settings, gains or (1.0,), kinds or KINDS,
            lambda numbers: watched(numbers, "sequences", len(numbers)),
        )  # fmt: skip
        share = found["sequences"]["explained"]
        if share is not None and share < FEW:
            echo(
                f"{array}: located loads explain the readings in {share:.0%} of the frames in contact, so its gains,"
                ' axes or depths are not those of the array; where they are unknown, quantity = "force" without gains'
                " uses the noise only",
                err=True,
            )
    if grasps or idle_minutes:
        from tactile.score.simulated import labelled_grasps, score_grasps  # the same

        seeds = _half(list(range(from_seed, from_seed + grasps)), half)
        if perturb:
            sources.append(labelled_grasps(seeds))
    if perturb:
        from tactile.score.perturb import chosen_perturbations  # the same
        from tactile.score.robustness import score_perturbed  # the same

        changes, cases = chosen_perturbations(perturb), [one.in_memory() for part in sources for one in part]
        runs = score_perturbed(cases, watched(changes, "perturbations", len(changes)), settings, window)
        if as_json:
            print_json({"perturbations": {name: one.plain() for name, one in runs}})
        else:
            _print_perturbations(runs)
        return
    if grasps or idle_minutes:
        simulated = score_grasps(watched(seeds, "grasps", len(seeds)), settings, idle_minutes, window)
        found["simulated"] = simulated.plain()
    if as_json:
        print_json(found)
        return
    simulated_figures, sequences = found.pop("simulated", None), found.pop("sequences", None)
    _print(found)
    if sequences is not None:
        _print_sequences(sequences)
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
        if value not in (None, {}, []):
            echo(f"{name.replace('_', ' ')}: {value}")


def _print_perturbations(runs: Iterable[tuple[str, "Robustness"]]) -> None:
    for number, (name, one) in enumerate(runs):
        kinds = sorted(one.kinds)
        if not number:
            heads = "  ".join(f"{kind + ' P, R':>20}" for kind in kinds)
            echo(f"{'perturbation':<26} {'false shear/min':>15}  {heads}")
        pairs = [", ".join(_ratio(value) for _, value in one.kinds[kind].ratios()) for kind in kinds]
        ratios = "  ".join(f"{pair:>20}" for pair in pairs)
        echo(f"{name:<26} {one.plain()['false_shear_events_a_minute']:>15}  {ratios}")


def _print_sequences(found: dict[str, Any]) -> None:
    echo(f"sequences, detected by {', '.join(found['kinds'])}:")
    for name, one in found["readings"].items():
        words = ", ".join(
            f"{what} " + " ".join(f"{1e3 * late:+.0f}" for late in one[key]) + " ms"
            for what, key in (("onset", "onset_error_s"), ("reported", "told_after_s")) if one[key] is not None
        )  # fmt: skip
        echo(
            f"readings {name:<20} accuracy {one['accuracy']:.3f}, false {_ratio(one['false_rate'])}"
            f" ({one['false']} false, {one['missed']} missed of {one['sequences']}), {words} (5 50 95 %)"
        )


def _ratio(value: float | None) -> str:
    return "-" if value is None or value != value else f"{value:.3f}"
