"""The command `sweep`: runs the cases of a TOML file to a Parquet table, and draws plots of it."""

from collections.abc import Mapping
from pathlib import Path

import click

from cnnsim.support.command_files import claim
from cnnsim.support.command_line import examples, print_json, replace_option
from cnnsim.support.terminal import echo, say

ERRORS = 20
"""Errors that the JSON output lists; the table has all."""


def sweep_command(kinds: Mapping[str, str], program: str, file: str, plot: str) -> click.Command:
    """Return the command `sweep` of a ``program`` with these ``kinds``: the module of each by name.

    ``file`` and ``plot`` are examples for its help.
    """

    @click.command(
        "sweep",
        epilog=examples(
            f"{program} sweep {file} -o study/ --workers 1",
            f"{program} sweep {file} -o study/ --plot {plot} --json",
        ),
        help=f"""Run all cases of a sweep file.

        SPEC is a TOML file with a kind ({", ".join(kinds)}) and a [grid] of choices.

        The table is DIR/table.parquet with one row a case; the row of a case that fails has its error. The same
        command resumes a stopped sweep.""",
    )
    @click.argument("spec", type=click.Path(path_type=Path))
    @click.option("-o", "--output", type=click.Path(path_type=Path), required=True, metavar="DIR",
                  help="Folder for the table, and for plots.")  # fmt: skip
    @click.option("--plot", "plots", multiple=True, metavar="X,Y[,COLOUR]",
                  help="Draw column Y against X, in colours by a third; may be repeated.")  # fmt: skip
    @click.option("--engine", default="processes", show_default=True,
                  help="Where: processes of this machine, or dask=ADDRESS of a scheduler.")  # fmt: skip
    @click.option("--workers", type=click.IntRange(1), help="Worker processes; without it one a core.")
    @replace_option
    @click.option("--json", "as_json", is_flag=True, help="Print JSON for a machine to read.")
    def sweep(
        spec: Path, output: Path, plots: tuple[str, ...], engine: str, workers: int | None, as_json: bool
    ) -> None:
        from cnnsim.sweep.plot import draw_columns, parse_plot
        from cnnsim.sweep.run import run_sweep
        from cnnsim.sweep.spec import read_sweep

        wanted = [parse_plot(text) for text in plots]
        files = [output / f"{y}-over-{x}{f'-by-{colour}' if colour else ''}.png" for x, y, colour in wanted]
        claim(*files)
        study = read_sweep(spec, kinds)
        found = run_sweep(study, output, engine=engine, workers=workers)
        drawn, several = {}, [key for key, values in study.grid.items() if len(values) > 1]
        for (x, y, colour), path in zip(wanted, files, strict=True):
            drawn[path] = [key for key in several if key not in (x, y, colour)]
            draw_columns(found.rows, x, y, colour, path, drawn[path])
        if as_json:
            errors = [{"case": row["case"], "error": row["error"]} for row in found.rows if row.get("error")]
            print_json({"cases": len(found.rows), "run": found.run, "failed": found.failed, "seconds": found.seconds,
                        "table": str(found.file), "plots": list(map(str, drawn)),
                        "errors": errors[:ERRORS]})  # fmt: skip
            return
        text = f"{len(found.rows)} cases, {found.run} run now, {found.failed} failed"
        if found.run:
            text += f", {found.seconds:.3g} s"
        say(f"{text} -> {found.file}")
        for path, keys in drawn.items():
            echo(f"-> {path}" + (f" (lines are means over {', '.join(keys)})" if keys else ""))

    return sweep
