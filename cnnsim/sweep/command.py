"""The command `sweep`, for any registry of kinds: a sweep's file run to a table and to plots."""

from collections.abc import Mapping
from pathlib import Path

import click

from cnnsim.support.command_line import examples, print_json
from cnnsim.support.terminal import echo, say

KEPT = 20
"""Failures that are shown as JSON; the table has all."""


def sweep_command(kinds: Mapping[str, str], program: str, file: str, plot: str) -> click.Command:
    """Return the command of a ``program`` whose sweeps are of these ``kinds``: the module of each.

    Its help has a ``file`` and a ``plot`` as examples.
    """

    @click.command(
        "sweep",
        epilog=examples(
            f"{program} sweep {file} -o study/ --workers 1",
            f"{program} sweep {file} -o study/ --plot {plot} --json",
        ),
        help=f"""Run all cases of a sweep file.

        SPEC is a TOML file with a kind ({", ".join(kinds)}) and a [grid] of choices.

        The table is DIR/table.parquet, a row a case; a case that fails is a row with its error. Run again after a
        crash, or with --plot, it goes on with what is there.""",
    )
    @click.argument("spec", type=click.Path(path_type=Path))
    @click.option("-o", "--output", type=click.Path(path_type=Path), required=True, metavar="DIR",
                  help="Folder for the table, and for plots.")  # fmt: skip
    @click.option("--plot", "plots", multiple=True, metavar="X,Y[,COLOUR]",
                  help="Draw column Y against X, in colours by a third; may be repeated.")  # fmt: skip
    @click.option("--engine", default="processes", show_default=True,
                  help="Where: processes, dask (on this machine) or dask=ADDRESS of a scheduler.")  # fmt: skip
    @click.option("--workers", type=click.IntRange(1), help="Worker processes; without it one a core.")
    @click.option("--json", "as_json", is_flag=True, help="Print JSON for a machine to read.")
    def sweep(
        spec: Path, output: Path, plots: tuple[str, ...], engine: str, workers: int | None, as_json: bool
    ) -> None:
        from cnnsim.sweep.plot import draw_columns, parse_plot
        from cnnsim.sweep.run import run_sweep
        from cnnsim.sweep.spec import read_sweep

        wanted = [parse_plot(text) for text in plots]
        found = run_sweep(read_sweep(spec, kinds), output, engine=engine, workers=workers)
        drawn = []
        for x, y, colour in wanted:
            drawn.append(output / f"{y}-over-{x}{f'-by-{colour}' if colour else ''}.png")
            draw_columns(found.rows, x, y, colour, drawn[-1])
        if as_json:
            errors = [{"case": row["case"], "error": row["error"]} for row in found.rows if row.get("error")]
            print_json({"cases": len(found.rows), "run": found.run, "failed": found.failed, "seconds": found.seconds,
                        "busy": found.busy, "table": str(found.file), "plots": list(map(str, drawn)),
                        "errors": errors[:KEPT]})  # fmt: skip
            return
        told = f"{len(found.rows)} cases, {found.run} run now, {found.failed} failed"
        if found.run:
            told += f", {found.seconds:.3g} s, {100 * found.busy:.0f} % of the cores' time in kernels"
        say(f"{told} -> {found.file}")
        for path in drawn:
            echo(f"-> {path}")

    return sweep
