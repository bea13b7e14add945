"""Command `layout`: looks at a table of another program and writes a layout of it."""

from pathlib import Path

import click

from cnnsim.support import InputError
from cnnsim.support.command_line import examples
from cnnsim.support.files import write_text
from cnnsim.support.terminal import echo
from tactile.cli.options import FILE


@click.command(
    epilog=examples(
        "tactile layout glove.csv", "tactile layout glove.csv -o layout.toml",
        "tactile run glove.csv --layout layout.toml",
    )
)  # fmt: skip
@click.argument("file", type=FILE)
@click.option("-o", "--output", type=FILE, help="Layout to write (.toml) instead of printing it.")
@click.option("--replace", is_flag=True, help="Overwrite an existing layout.")
def layout(file: Path, output: Path | None, replace: bool) -> None:
    """Guess the layout of a table of another program.

    FILE is a text table (.csv, .tsv, .txt), an array file (.npy, .npz, .mat, .h5), a Parquet file, an MCAP file or a
    ROS bag, or a folder of them, of which the first is read. The layout lists the columns with their ranges, rates and
    noise; lines with (?) are to be checked. docs/bring-your-own-recording.md has all keys.
    """
    from tactile.layout.guess import guess  # imported when used
    from tactile.layout.guess_text import layout_text  # the same
    from tactile.layout.layout import parse_layout  # the same
    from tactile.layout.source import read_foreign  # the same
    from tactile.layout.table import READERS, read_table  # the same
    from tactile.sources import is_folder_of_recordings  # the same

    if not file.exists():
        raise InputError(f"no file {file}")
    if is_folder_of_recordings(file):
        inside = [one for one in sorted(file.rglob("*")) if one.suffix.lower() in READERS]
        if not inside:
            raise InputError(f"{file}: no table in it; one of {', '.join(READERS)} wanted")
        file = inside[0]
    table = read_table(file)
    text = layout_text(table, guess(table))
    source = read_foreign(file, parse_layout(text, str(file)))
    if output is None:
        echo(text)
    else:
        write_text(output, text, replace=replace)
        echo(f"-> {output}")
    sizes = ", ".join(f"{array.name} {array.rows} x {array.cols}" for array in source.arrays)
    echo(f"{file.name}: {source.frames} frames of {sizes}", err=output is None)
    for note in source.notes:
        echo(f"note: {note}", err=True)
