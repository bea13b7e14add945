"""Command `accuracy`: what accuracy costs in a scene."""

from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING

import click

from cnnsim.support.command_files import claim
from cnnsim.support.command_line import examples, print_json, replace_option, watched
from cnnsim.support.files import write_rows, writing
from cnnsim.support.terminal import echo
from tactile.cli.options import FILE, JSON

if TYPE_CHECKING:
    from tactile.simulator.tradeoff import Trade


@click.command(
    epilog=examples(
        "tactile accuracy examples/scenes/grip.toml",
        "tactile accuracy examples/scenes/needle.toml -o accuracy.png --csv accuracy.csv",
        "tactile accuracy scene.toml --tolerance 0.05 --json",
    )
)
@click.argument("scene", type=FILE)
@click.option("--tolerance", "tolerances", type=float, multiple=True, help="Tolerance instead of 0.3 to 0.001; again.")
@click.option("-o", "--output", type=FILE, help="File of the diagram (PNG, SVG, PDF).")
@click.option("--csv", "table", type=FILE, help="File of the figures, one line per tolerance.")
@replace_option
@JSON
def accuracy(
    scene: Path, tolerances: tuple[float, ...], output: Path | None, table: Path | None, as_json: bool
) -> None:
    """Measure time and error of a scene for each tolerance.

    SCENE is computed with all its effects, and with effects = "auto" for each tolerance.

    Errors are the largest over the whole recording and three seeds, relative to the peak of the ideal skin. A scene of
    more than 400 frames is computed at a lower rate.
    """
    from tactile.simulator.scene_file.file import bare_scene, scene_table  # not for --help
    from tactile.simulator.tradeoff import TOLERANCES, trades  # the same

    claim(output, table)
    bare, _ = bare_scene(scene_table(scene), str(scene), scene.parent)
    chosen = tolerances or TOLERANCES
    rows = list(watched(trades(bare, chosen), "tolerances", len(chosen) + 1))
    if table is not None:
        write_rows(table, [asdict(row) | {"left_out": " ".join(row.left_out)} for row in rows])
    if output is not None:
        _draw(rows, output, bare.title)
    if as_json:
        print_json({"title": bare.title, "rows": [asdict(row) for row in rows]})
        return
    whole = rows[0].seconds
    echo(f"{bare.title}: all effects {whole * 1e6:.3g} us a frame")
    for row in rows[1:]:
        left = ", ".join(row.left_out) or "nothing"
        echo(
            f"tolerance {row.tolerance:g}: error {row.error:.2g} (at most {row.bound:.2g}), {row.seconds * 1e6:.3g} us "
            f"a frame, {row.seconds / whole:.2g} x; chosen in {row.choosing * 1e3:.3g} ms; left out: {left}"
        )


def _draw(rows: list["Trade"], output: Path, title: str) -> None:
    from matplotlib.figure import Figure  # slow to import, and only needed for the diagram

    from tactile.output.tradeoff_plot import draw_trades  # the same

    figure = Figure(figsize=(6.5, 4.5), layout="constrained")
    draw_trades(rows, figure.subplots(), title)
    with writing(output) as beside:
        figure.savefig(beside, dpi=120)
