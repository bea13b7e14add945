"""Command `convert`: writes the frames of a source in another format."""

from pathlib import Path

import click

from cnnsim.support.command_line import examples, watched
from cnnsim.support.terminal import echo
from tactile.cli.options import FILE


@click.command(
    epilog=examples(
        "tactile convert hand.mcap hand.csv", "tactile convert grasp.npz grasp.mcap",
        "tactile convert examples/scenes/grip.toml grip.npz",
    )
)  # fmt: skip
@click.argument("source", type=FILE)
@click.argument("target", type=FILE)
@click.option("--replace", is_flag=True, help="Write over TARGET if it is there already.")
def convert(source: Path, target: Path, replace: bool) -> None:
    """Convert recordings and scenes to another file format.

    The frames of SOURCE are written to TARGET (.csv, .npz, .parquet, .mcap) without loss.

    SOURCE is what `tactile run` takes: a recording (.mcap, .npz, .csv, .parquet), a ROS bag (.bag, .db3 or a folder)
    or a scene (.toml). What TARGET cannot hold is said on stderr.
    """
    from tactile.sources.convert import convert as write  # imported when used

    there = target.exists()
    done = write(source, target, replace, lambda frames, total: watched(frames, "frames", total))
    for note in done.notes:
        echo(note, err=True)
    echo(f"wrote {done.frames} frames to {target}{', replacing what was there' * there}")
