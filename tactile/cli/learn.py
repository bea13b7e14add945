"""Command `learn`: a detector from labelled recordings and simulated grasps."""

from collections.abc import Iterable
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from cnnsim.support import InputError
from cnnsim.support.command_files import claim
from cnnsim.support.command_line import examples, print_json, replace_option, watched
from cnnsim.support.files import write_text
from cnnsim.support.terminal import echo, say
from tactile.cli.options import FILE, JSON, LAYOUT, Finite
from tactile.core.source import Source, provenance
from tactile.settings import PipelineOptions, Settings
from tactile.sources import layout_of

if TYPE_CHECKING:  # imported when used
    from tactile.learning.trial import Row
    from tactile.score.labels import LabelledSource

GROUPS = "gain,rate,noise,rotation,dead"


@click.command(
    epilog=examples(
        "tactile learn grasps/ --labels grasps/labels.csv --kind contact --perturb none",
        "tactile learn --grasps 3 --kind slip --planes full,sticking,driven --perturb gain -o my-slip.toml --json",
    )
)
@click.argument("folder", type=FILE, required=False)
@click.option("--labels", type=FILE, help="CSV as of `tactile score`; a kind of your own has a column KIND_s.")
@click.option("--kind", required=True, help="Kind of event to be learned, such as slip.")
@click.option("--grasps", type=click.IntRange(0, 100_000), default=0, help="Also learn from simulated grasps.")
@click.option("--from-seed", type=click.IntRange(0), default=0, show_default=True, help="Seed of the first grasp.")
@click.option("-o", "--output", type=FILE, help="Detector file [the kind, .toml].")
@click.option("--planes", default="", help="Planes to choose from, with commas [all without a direction].")
@click.option("--weights", type=click.IntRange(1, 200), default=10, show_default=True, help="Most weights.")
@click.option("--lasting-ms", type=Finite(0, min_open=True), default=200.0, show_default=True,
              help="Time for which an event surely lasts; the rest of its contact is not used.")  # fmt: skip
@click.option("--perturb", default=GROUPS, show_default=True, help="Groups of `tactile score --perturb`, all or none.")
@click.option("--seed", type=click.IntRange(0), default=0, show_default=True, help="Of the choice of taxels.")
@replace_option
@LAYOUT
@JSON
def learn(
    folder: Path | None, labels: Path | None, kind: str, output: Path | None, perturb: str, layout: Path | None,
    as_json: bool, **chosen: Any,
) -> None:  # fmt: skip
    """Learn a detector from labelled recordings.

    FOLDER has recordings and LABELS the times of the event; --grasps adds simulated grasps. A labelled finger without a
    time of the event is an example without it. A template on planes of the taxels is fitted: the event is on where it
    turns touched taxels black. The detector file runs with --program. If a shipped detector makes the kind, that of the
    file is learned_KIND.

    The table has precision and recall on recordings that were held out, each in one of four parts, and on arrays that
    were held out, then under perturbations. The shipped detector and a baseline of a few lines stand next to it.
    """
    if (folder is None) != (labels is None):
        raise click.UsageError("a folder and --labels, or neither, wanted")
    if folder is None and not chosen["grasps"]:
        raise click.UsageError("nothing to learn from; a folder and --labels, or --grasps, wanted")
    from tactile.learning.front import front_of  # NumPy is slow to import
    from tactile.learning.learn import LearningTask  # the same
    from tactile.learning.learn import learn as learned
    from tactile.learning.trial import rows
    from tactile.score.perturb import UNCHANGED, chosen_perturbations

    changes = [] if perturb == "none" else [one for one in chosen_perturbations(perturb) if one != UNCHANGED]
    if any(one.tempo != 1 for one in changes):
        raise InputError(f"--perturb {perturb}: times of the labels would change; groups without tempo wanted")
    front = front_of([name.strip() for name in chosen["planes"].split(",") if name.strip()])
    task = LearningTask(kind, front, chosen["weights"], 1e-3 * chosen["lasting_ms"], chosen["seed"])
    path = output or Path(f"{task.own_kind.replace('_', '-')}.toml")
    if path.suffix != ".toml":
        raise InputError(f"{path}: suffix {path.suffix!r}, .toml wanted")
    claim(path)
    cases = _cases(folder, labels, kind, layout, chosen)
    lesson = learned(cases, task, _settings, lambda some: watched(some, "recordings", len(cases)))
    write_text(path, lesson.text(path.stem))
    table: dict[str, Row] = {}
    with lesson.held_out() as held:
        for name, row in rows(cases, held, (kind, task.own_kind), _settings, watched(changes, "trial", len(changes))):
            table[name] = row
            if not as_json:
                _print(name, row, first=len(table) == 1)
    numbers = lesson.learned
    if as_json:
        print_json({
            "detector": str(path), "kind": task.own_kind, "fingers": len(lesson.examples),
            "with_event": sum(bool(one.known) for one in lesson.examples), "planes": numbers.front.names,
            "weights": numbers.weights.tolist(), "z": numbers.z, "more_than_half": numbers.most,
            "confirm_s": numbers.confirm, "lag_s": numbers.lag,
            "trial": {name: {one: tally.plain() for one, tally in row.items()} for name, row in table.items()},
        })  # fmt: skip
        return
    if not table:
        say("trial     none: two recordings with the event wanted, so that one can be held out", 10)
    say(f"planes    {', '.join(numbers.front.names)}", 10)
    echo(f"-> {path}")


def _settings(source: Source) -> Settings:
    return PipelineOptions(tare="auto" if provenance(source).untared else "off").settings(source)


def _cases(
    folder: Path | None, labels: Path | None, kind: str, layout: Path | None, chosen: dict[str, Any]
) -> list["LabelledSource"]:
    from tactile.score.labels import read_labels  # NumPy is slow to import
    from tactile.score.measure import labelled_sources  # the same
    from tactile.score.simulated import labelled_grasps  # the same

    parts: list[Iterable[LabelledSource]] = []
    if folder is not None and labels is not None:
        missing, opened = labelled_sources(folder, read_labels(labels, kind), layout_of(folder, layout))
        if missing:
            raise InputError(f"{folder}: no recording of the labels {', '.join(missing)}; all of them wanted")
        parts.append(opened)
    first = chosen["from_seed"]
    parts.append(labelled_grasps(range(first, first + chosen["grasps"])))
    return [one.in_memory() for part in parts for one in part]


def _print(name: str, row: "Row", *, first: bool) -> None:
    if first:
        heads = "  ".join(f"{one + ' P, R, error':>24}" for one in row)
        echo(f"{'':<28}{heads}")
    cells = []
    for tally in row.values():
        ratios = ", ".join("-" if value != value else f"{value:.2f}" for _, value in tally.ratios())
        error = tally.plain()["onset_error_s"]
        cells.append(f"{ratios}, {'-' if error is None else f'{1e3 * error[1]:+.0f} ms'}")
    echo(f"{name:<28}" + "  ".join(f"{cell:>24}" for cell in cells))
