"""Commands that write files: convert, new."""

from collections.abc import Iterable
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING

import click

from cnnsim.support.command_files import check_free
from cnnsim.support.command_line import examples, watched
from cnnsim.support.extras import need
from cnnsim.support.files import check_name, write_text
from cnnsim.support.terminal import echo
from tactile.cli.new_texts import ARRAY, DETECTOR, SCENE
from tactile.cli.options import FILE, LAYOUT
from tactile.core.source import provenance
from tactile.sources import open_source

if TYPE_CHECKING:
    from tactile.core.frame import Frame
    from tactile.export.episode import Watch

FPS = 30
"""Frames per second of a learning set."""


@click.command(
    epilog=examples(
        "tactile new scene my-touch", "tactile run my-touch.toml",
        "tactile new array my-skin -o skins/", "tactile emulate --array skins/my-skin.toml --scene my-touch.toml",
        "tactile new detector my-events", "tactile run my-touch.toml --program my-events.toml",
        "tactile new firmware --array skins/my-skin.toml",
    )
)  # fmt: skip
@click.argument("kind", type=click.Choice(["scene", "array", "detector", "firmware"]))
@click.argument("name", required=False)
@click.option("--array", "-a", type=FILE, help="Array description (TOML) of the board; of a firmware.")
@click.option(
    "--rate-hz", type=click.IntRange(1, 100_000), help="Frames per second of each array; of a firmware [100]."
)
@click.option("-o", "--output", type=click.Path(path_type=Path, file_okay=False), default=Path(), show_default=".",
              help="Folder for it.")  # fmt: skip
@click.option("--replace", is_flag=True, help="Overwrite an existing file.")
def new(
    kind: str, name: str | None, array: Path | None, rate_hz: int | None, output: Path, replace: bool
) -> None:  # fmt: skip
    """Write a commented file NAME.toml, or the firmware of a board.

    The file runs as it is. A scene is what touches simulated fingers; an array describes a device on a port; a
    detector is a program whose planes mean events. A firmware is a folder NAME (that of
    the array file unless given) with an Arduino sketch and a CircuitPython file for the
    board that --array describes.
    """
    if kind == "firmware":
        _new_firmware(name, array, rate_hz, output, replace)
        return
    if name is None:
        raise click.UsageError(f"NAME of the {kind} wanted")
    if (array, rate_hz) != (None, None):
        raise click.UsageError(f"--array and --rate-hz belong to a firmware, not to a {kind}")
    path = output / f"{check_name(name, kind)}.toml"
    write_text(
        path, {"scene": SCENE, "array": ARRAY, "detector": DETECTOR}[kind].replace("NAME", name), replace=replace
    )
    echo(f"-> {path}")
    if kind == "scene":
        echo(f"to run it: tactile run {path} -o out/")
    elif kind == "detector":
        echo(f"to run it: tactile run SCENE.toml --program {path}; its planes: tactile planes")
    else:
        echo(f"to read a board: tactile live -p PORT -a {path}; PORT is one of `tactile ports`")
        echo(f"without one: tactile emulate --array {path} --scene SCENE.toml prints a port")


def _new_firmware(name: str | None, array: Path | None, rate: int | None, output: Path, replace: bool) -> None:
    """Write the files of a firmware into a folder of its name, which the Arduino program wants."""
    from tactile.wire.description_file import read_description  # NumPy is slow to import
    from tactile.wire.firmware import RATE, firmware  # the same

    if array is None:
        raise click.UsageError("--array FILE of the board wanted")
    name = check_name(name or array.stem, "firmware")
    folder = output / name
    there = [path for path in (folder / f"{name}.ino", folder / "code.py") if replace and path.is_file()]
    filled = {path.name: path.read_text(encoding="utf-8") for path in there}
    files = firmware(read_description(array), name, rate or RATE, filled)
    check_free(*(folder / file for file in files), replace=replace)
    for file, text in files.items():
        write_text(folder / file, text, replace=replace)
    echo(f"-> {folder}/: {', '.join(files)}")
    if filled:
        echo(f"{' and '.join(filled)}: the configuration is new, the rest is kept")
        return
    echo("fill in read_taxels of the sketch (Arduino) or of code.py (CircuitPython), and load it into the board")
    echo(f"to read it: tactile live -p PORT -a {array}; PORT is one of `tactile ports`")


@click.command(
    epilog=examples(
        "tactile convert hand.mcap hand.csv", "tactile convert grasp.npz grasp.mcap",
        "tactile convert examples/scenes/grip.toml grip.npz", "tactile convert glove.csv g.mcap --layout glove.toml",
        "tactile convert examples/grasp.npz --ros2 grasp-bag",
        "tactile convert examples/grasp.npz --lerobot learning-set --fps 30",
    )
)  # fmt: skip
@click.argument("source", type=FILE)
@click.argument("target", type=FILE, required=False)
@LAYOUT
@click.option("--replace", is_flag=True, help="Overwrite an existing TARGET.")
@click.option("--tared", is_flag=True, help="Write the frames after tare and gains, as the pipeline takes them.")
@click.option("--drawable", is_flag=True, help="Add messages that Foxglove, Lichtblick and RViz draw (.mcap).")
@click.option("--ros2", type=FILE, help="Folder for a ROS 2 bag of standard messages, in place of TARGET; tared.")
@click.option("--lerobot", type=FILE, help="Folder for a LeRobotDataset v3.0, in place of TARGET; tared.")
@click.option("--fps", type=click.IntRange(1, 10_000), help="Frames per second of a learning set [30].")
@click.option("--task", help="Text of the task of a learning set [the title of the recording].")
def convert(
    source: Path, target: Path | None, replace: bool, tared: bool, drawable: bool, ros2: Path | None,
    lerobot: Path | None, fps: int | None, task: str | None, layout: Path | None,
) -> None:  # fmt: skip
    """Convert recordings and scenes to another file format.

    The frames of SOURCE are written to TARGET (.csv, .npz, .parquet, .mcap) without loss.

    SOURCE is what `tactile run` takes: a recording (.mcap, .npz, .csv, .parquet), a ROS bag (.bag, .db3 or a folder),
    a table of another program with its --layout, or a scene (.toml). What TARGET cannot hold is said on stderr. With
    --lerobot each recording of a folder is an episode.
    """
    if sum(one is not None for one in (target, ros2, lerobot)) != 1:
        raise click.UsageError("one target wanted: a file, --ros2 FOLDER or --lerobot FOLDER")
    if lerobot is None and (fps, task) != (None, None):
        raise click.UsageError("--fps and --task belong to --lerobot FOLDER")
    if tared and drawable:
        raise click.UsageError("--drawable messages are tared, and frames beside them are not; leave out --tared")

    def watch(frames: "Iterable[Frame]", total: int | None) -> "Iterable[Frame]":
        return watched(frames, "frames", total)

    if lerobot is not None:
        _learning_set(source, lerobot, fps or FPS, task, watch, layout)
        return
    from tactile.export.tared import drawn, open_for_export, write_ros2  # imported when used
    from tactile.export.tared import tared as after_tare  # the same

    if ros2 is not None:
        need("rosbags", "a ROS 2 bag")
        exported = open_for_export(source, layout)
        frames, start = watch(exported.source, exported.source.frames), provenance(exported.source).start_ns or 0
        count = write_ros2(ros2, drawn(exported, frames, start, ros=True))
        echo(f"wrote {count} messages to {ros2}; to play them: ros2 bag play {ros2}")
        return
    assert target is not None
    from tactile.sources.convert import convert as write  # the same

    opened = None if layout is None else open_source(source, layout)
    if tared:
        opened = after_tare(source, layout)
    others = None
    if drawable:
        need("tactile.export.drawable", "messages for viewers")
        others = partial(drawn, open_for_export(source, layout))
    there = target.exists()
    done = write(source, target, replace, watch, opened, others)
    for note in done.notes:
        echo(note, err=True)
    echo(f"wrote {done.frames} frames to {target}{', replacing what was there' * there}")


def _learning_set(
    source: Path, folder: Path, fps: int, task: str | None, watch: "Watch", layout: Path | None
) -> None:  # fmt: skip
    writer = need("tactile.export.lerobot", "a LeRobot dataset")
    frames, episodes = writer.write_lerobot(source, folder, fps, task, watch, layout)
    echo(f"wrote {frames} frames at {fps} frames/s in {episodes} episode{'s' * (episodes != 1)} to {folder}")
