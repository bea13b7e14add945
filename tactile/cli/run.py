"""The command that runs a scene or a recording through the pipeline."""

from collections import deque
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any, cast

import click

from cnnsim import InputError, backends
from cnnsim.support.command_line import examples, print_json, watched
from cnnsim.support.echo import echo, say
from tactile.calibration.gains import Gains
from tactile.calibration.live_tare import TareMode
from tactile.cli.options import TareChoice, check_thresholds, detection
from tactile.core.frame import TaxelArray
from tactile.core.source import FrameStream, provenance
from tactile.settings import PipelineOptions, Settings
from tactile.sources import open_source

if TYPE_CHECKING:
    from tactile.cli.live import LiveOptions
    from tactile.simulator.bump_cover import Bumps
    from tactile.simulator.scene.scene import Scene


@click.command(
    epilog=examples(
        "tactile run examples/scenes/grip.toml -o out/grip",
        "tactile run grasp.npz -o out/grasp --program two-blobs.toml",
        "tactile run grasp.npz --sign-code --json",
    )
)
@click.argument("source", type=click.Path(path_type=Path))
@click.option(
    "-o", "--output", type=click.Path(path_type=Path), help="Folder for frames.csv, events.json and touch.png."
)
@click.option("--parquet", is_flag=True, help="Write the rows of frames.csv as frames.parquet, too.")
@detection
@click.option("--window", type=int, default=128, show_default=True, help="Frames a texture figure averages.")
@click.option("--floor", type=float, help="Normal signal below which texture figures are not valid.")
@click.option(
    "--tare",
    type=TareChoice(),
    help="How the offset is taken: auto from still, unloaded frames, off, or from so many frames at the start"
    " [auto for a device's readings, else off].",
)
@click.option("--gains", help="SHEAR,NORMAL: factors from readings to strain, stress or force (eq. 15).")
@click.option("--calibration", type=click.Path(path_type=Path), help="Gains, depth and correction of a skin.")
@click.option("--backend", type=click.Choice(backends.NAMES), default="cpu", show_default=True)
@click.option("--json", "as_json", is_flag=True, help="Print JSON for a machine to read.")
def run(
    source: Path, output: Path | None, parquet: bool, tare: TareMode | None, gains: str | None,
    calibration: Path | None, as_json: bool, **chosen: Any,
) -> None:  # fmt: skip
    """Run SOURCE through the pipeline.

    SOURCE is a scene (.toml), a recording (.npz, .csv, .parquet, .mcap) or a ROS bag (.bag, .db3 or a folder).
    """
    from tactile import pipeline  # the machine is loaded only when it runs
    from tactile.output.collected import Collected  # the same
    from tactile.output.json_data import run_data  # the same
    from tactile.output.record import Record  # the same
    from tactile.output.tables import tables  # the same
    from tactile.output.truth import truth_of  # the same

    if parquet and output is None:
        raise click.UsageError("--parquet writes beside frames.csv; -o FOLDER wanted")
    frames = open_source(source)
    check_thresholds(chosen)
    if calibration is not None and gains is not None:
        raise click.UsageError("--calibration has gains; leave out --gains")
    known = provenance(frames)
    if known.uncalibrated and calibration is None and gains is None:
        raise InputError(
            f"{source}: finger {known.uncalibrated[0]!r}: readings in the unit of the wire, which is no quantity;"
            " --gains SHEAR,NORMAL or --calibration FILE wanted"
        )
    lived = _recorded(known.choices, source)
    mode = tare if tare is not None else lived.tare if lived else ("auto" if known.untared else "off")
    skin = lived.skin if lived else None
    if calibration is not None:
        from tactile.calibration.file import load_calibration  # SciPy's splines are slow to import

        skin = load_calibration(calibration)
    options = lived.but(chosen) if lived else PipelineOptions(**chosen)
    settings = replace(options, tare=mode).settings(frames.arrays, skin, _gains(gains))
    if hasattr(frames, "loads_at"):  # a scene
        from tactile.simulator.scene.model_range import out_of_range  # only where called for

        for line in out_of_range(cast("Scene", frames)):
            say(f"note: {line}", err=True)
    bumps = getattr(frames, "bumps", None)  # scenes may have them
    note = ""
    if bumps is not None and calibration is None:
        settings, note = _on_bumps(settings, frames.arrays, bumps)
    pipeline.warm_up(frames.arrays, frames.modulus, settings)  # else the first latencies are the compiler's
    truth = truth_of(frames)
    collected = Collected(truth)
    seen = watched(frames, "touch", frames.frames)
    asked: deque[bool] = getattr(frames, "tare_requests", deque())  # of recordings in which a tare was asked for
    passed = FrameStream(frames.title, frames.arrays, frames.modulus, frames.frames, seen, known, asked)
    if output is None:
        pipeline.run(passed, settings, [collected])
    else:
        with Record(
            output,
            frames.arrays,
            {"source": source.name, "title": frames.title, "tare": mode},
            truth,
            parquet=parquet,
        ) as record:
            pipeline.run(passed, settings, [collected, record])
    if as_json:
        print_json(run_data(collected, frames.arrays))
    else:
        tables(collected, frames.arrays)
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
    if note:
        echo(note, err=as_json)
    if output is not None:
        from tactile.output.plot import draw  # matplotlib is slow to import

        draw(collected, frames.arrays, frames.title, output / "touch.png")
        also = f", {output / 'frames.parquet'}" if parquet else ""
        echo(f"wrote {output / 'frames.csv'}, {output / 'events.json'}, {output / 'touch.png'}{also}", err=as_json)


def _recorded(choices: str, source: Path) -> "LiveOptions | None":
    """Return the options of the live run that recorded a source, None where it was none."""
    if not choices:
        return None
    from tactile.cli.live import recorded_options  # only here

    return recorded_options(choices, str(source))


def _gains(text: str | None) -> Gains | None:
    if text is None:
        return None
    try:
        shear, normal = (float(part) for part in text.split(","))
    except ValueError as error:
        raise click.UsageError(f"--gains {text!r}; two numbers SHEAR,NORMAL wanted") from error
    return Gains(shear, normal)


def _on_bumps(settings: Settings, arrays: tuple[TaxelArray, ...], bumps: "Bumps") -> tuple[Settings, str]:
    """The settings with which a flat cover's inverse gives a load on a bump its force, and what was done, in words."""
    from tactile.calibration.radial import RadialCorrection  # SciPy's splines are slow to import

    factors = {array.name: bumps.over_flat(array, array.quantity) for array in arrays}
    factor = max(factors.values())
    if min(factors.values()) < factor * (1 - 1e-9):
        each = ", ".join(f"{name} {one:.3g}" for name, one in factors.items())
        return settings, f"forces are a flat cover's; times so much they are right for a load on one bump: {each}"
    said = f"forces are {factor:.3g} times a flat cover's: right for a load on one bump, not between bumps"
    return replace(settings, radial=RadialCorrection.constant(factor)), said
