"""The command that writes the frames of a source in another form."""

from pathlib import Path

import click

from cnnsim.support.command_line import examples
from tactile.cli.options import FILE


@click.command(epilog=examples("tactile convert hand.mcap hand.csv", "tactile convert grasp.npz grasp.mcap"))
@click.argument("source", type=FILE)
@click.argument("target", type=FILE)
@click.option("--overwrite", is_flag=True, help="Replace TARGET if there is one.")
def convert(source: Path, target: Path, overwrite: bool) -> None:
    """Write the frames of SOURCE (.mcap, .npz, .csv, .bag, .toml) as TARGET (.csv, .npz, .parquet, .mcap)."""
    from tactile.sources.convert import convert as write  # only here

    click.echo(f"wrote {write(source, target, overwrite)} frames to {target}")
