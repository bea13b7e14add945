"""The command that runs a scene or a recording through the pipeline."""

from pathlib import Path
from typing import Any

import click

from cnnsim import backends
from cnnsim.support.command_files import claim
from cnnsim.support.command_line import examples, print_json, replace_option, watched
from cnnsim.support.terminal import echo, say
from tactile.calibration.gains import Gains
from tactile.calibration.live_tare import TareMode
from tactile.cli.options import FILE, JSON, LAYOUT, TareChoice, check_thresholds, detection
from tactile.core.source import Source, provenance, with_frames
from tactile.events.event import MOST_NEWTONS
from tactile.opened import RunChoices, open_for_run
from tactile.settings import PipelineOptions
from tactile.sources import is_folder_of_recordings
from tactile.wire.reading import Counts
from tactile.wire.source import WireSource


@click.command(
    epilog=examples(
        "tactile run examples/scenes/grip.toml -o out/grip",
        "tactile run grasp.npz -o out/grasp --program two-blobs.toml",
        "tactile run grasp.npz --sign-code --json",
        "tactile run grasps/ -o out/grasps --parquet",
    )
)
@click.argument("source", type=FILE)
@click.option(
    "-o",
    "--output",
    type=FILE,
    help="Folder for frames.csv, events.json and touch.png; of many recordings for events.csv.",
)
@click.option("--parquet", is_flag=True, help="Write the rows of the .csv file as .parquet, too.")
@detection
@click.option("--window", type=int, help="Frames a texture figure averages [128].")
@click.option("--floor", type=float, help="Normal signal below which texture figures are not valid.")
@click.option(
    "--tare",
    type=TareChoice(),
    help="How the offset is taken: auto (from still, unloaded frames), off, or N: mean of the first N frames"
    " [auto for a device's readings, else off].",
)
@click.option("--gains", help="SHEAR,NORMAL: factors from readings to strain, stress or force (eq. 15).")
@click.option("--calibration", type=FILE, help="Gains, depth and correction of a skin.")
@click.option("--backend", type=click.Choice(backends.NAMES), help="Where the machine runs [cpu].")
@LAYOUT
@replace_option
@JSON
def run(
    source: Path, output: Path | None, parquet: bool, tare: TareMode | None, gains: str | None,
    calibration: Path | None, layout: Path | None, as_json: bool, **chosen: Any,
) -> None:  # fmt: skip
    """Run the pipeline on a scene, a recording or a folder.

    SOURCE is a scene (.toml), a recording (.npz, .csv, .parquet, .mcap), a ROS bag (.bag, .db3 or a folder), or a
    table of another program, which has a --layout; or a folder of them, whose events make one table, events.csv: an
    unreadable recording is a row with its error.
    """
    from tactile import pipeline  # imported when used
    from tactile.output.collected import Collected  # the same
    from tactile.output.ground_truth import truth_of  # the same
    from tactile.output.invalid_readings import InvalidReadings  # the same
    from tactile.output.json_data import run_data, settings_data  # the same
    from tactile.output.record import RunRecord  # the same
    from tactile.output.tables import tables  # the same

    if parquet and output is None:
        raise click.UsageError("--parquet without a folder to write to; -o FOLDER wanted")
    check_thresholds(chosen)
    if calibration is not None and gains is not None:
        raise click.UsageError("--calibration has gains; leave out --gains")
    if output is not None:
        rows = "events" if is_folder_of_recordings(source) else "frames"
        claim(output / f"{rows}.csv", output / f"{rows}.parquet" if parquet else None)
        claim(*(output / name for name in ("events.json", "touch.png") if rows == "frames"))
    choices = RunChoices(PipelineOptions(**chosen), tare, _gains(gains), calibration, layout)
    if is_folder_of_recordings(source):
        from tactile.cli.run_folder import run_folder  # imported when used

        run_folder(source, choices, output, parquet=parquet, as_json=as_json)
        return
    opened = open_for_run(source, choices)
    frames, settings, mode = opened.source, opened.settings, opened.mode
    for line in opened.notes:
        say(f"note: {line}", err=True)
    pipeline.warm_up(frames.arrays, frames.modulus, settings)  # else the first latencies are the compiler's
    truth, known = truth_of(frames), provenance(frames)
    damage = {"damage": known.damage} if known.damage else {}
    collected = Collected(truth)
    unread = InvalidReadings(frames.arrays)
    seen = watched(unread.through(frames), "touch", frames.frames)
    passed = with_frames(frames, seen)
    if output is None:
        pipeline.run(passed, settings, [collected])
    else:
        with RunRecord(
            output,
            frames.arrays,
            {
                "source": source.name,
                "title": frames.title,
                "start_ns": known.start_ns,
                **damage,
                "settings": settings_data(settings),
            },
            truth,
            parquet=parquet,
        ) as record:
            pipeline.run(passed, settings, [collected, record])
    if as_json:
        print_json(run_data(collected, frames.arrays, settings))
    else:
        tables(collected, frames.arrays)
    for line in [*_left_on_the_wire(frames), *unread.lines]:
        echo(line, err=True)
    if any("in the unit of the readings" in event.words for event in collected.events):
        words = "if the device sends millinewtons, --gains 0.001,0.001 or gains in the array description are wanted"
        echo(f"forces above {MOST_NEWTONS:g} N, which no finger bears: {words}", err=True)
    for note in collected.notes:
        if note.notice:
            echo(f"{frames.arrays[note.finger].name}: {note.why}: {note.detail}", err=True)
    for array in frames.arrays if mode not in ("off", 0) else ():
        check = collected.tare(array)
        if check is None:
            count = collected.columns(array.name).t.size
            if isinstance(mode, int):
                echo(f"{array.name}: tare over {mode} frames, {count} there; fewer wanted (--tare N)", err=True)
                continue
            why = next((f"{note.why}: {note.detail}" for note in reversed(collected.notes) if note.detail), "too few")
            echo(f"{array.name}: no tare in {count} frames ({why}); --tare N takes the first N", err=True)
        elif check.warning and as_json:
            echo(f"{array.name}: tare: {check.words}", err=True)
    for array in frames.arrays if tare is None and mode == "off" and truth is None else ():
        began = collected.columns(array.name).t[:1]
        if any(one.kind == "contact" and one.finger == array.name and one.t <= began for one in collected.events):
            words = "in contact from the first frame, without a tare; if nothing touched then, --tare auto takes one"
            echo(f"{array.name}: {words}", err=True)
    if opened.forces:
        echo(opened.forces, err=as_json)
    if output is not None:
        from tactile.output.plot import draw  # matplotlib is slow to import

        draw(collected, frames.arrays, frames.title, output / "touch.png")
        also = f", {output / 'frames.parquet'}" if parquet else ""
        echo(f"wrote {output / 'frames.csv'}, {output / 'events.json'}, {output / 'touch.png'}{also}", err=as_json)


def _gains(text: str | None) -> Gains | None:
    """Return the gains in a text SHEAR,NORMAL."""
    if text is None:
        return None
    try:
        shear, normal = (float(part) for part in text.split(","))
    except ValueError as error:
        raise click.UsageError(f"--gains {text!r}; two numbers SHEAR,NORMAL wanted") from error
    return Gains(shear, normal)


def _left_on_the_wire(source: Source) -> list[str]:
    """Report bytes of a recording that made no frames, if there are no frames or the description fits badly."""
    counts: Counts | None = getattr(source, "counts", None)
    if counts is None or not (counts.unfit or not counts.good):
        return []
    shapes = ", ".join(f"{array.name} {array.rows} x {array.cols}" for array in source.arrays)
    unfit = source.decoder.unfit if isinstance(source, WireSource) else ""
    found = f"found are {unfit}; " if unfit else ""
    return [f"bytes of the wire: {counts}; {found}described are {shapes}"]
