"""The command line of the machine: the commands about the library, and those that other files add."""

from pathlib import Path

import click
import numpy as np
from numpy.typing import NDArray

from cnnsim import library
from cnnsim.cli_devices import devices
from cnnsim.cli_formats import export, import_
from cnnsim.cli_prototyping import design, robust, trace
from cnnsim.cli_run import json_option, program, run, without_option
from cnnsim.command import CommandGroup, examples, print_json
from cnnsim.errors import InputError
from cnnsim.picture import to_ascii


@click.group(cls=CommandGroup, context_settings={"help_option_names": ["-h", "--help"]})
@click.version_option(package_name="cellular-wave-touch")
@click.option(
    "--library",
    "folders",
    type=click.Path(path_type=Path),
    multiple=True,
    help="A folder of your own templates; of several the last comes first.",
)
@click.pass_context
def main(context: click.Context, folders: tuple[Path, ...]) -> None:
    """Run templates and programs of a cellular neural network universal machine."""
    context.with_resource(library.using(*folders))


for command in (run, program, trace, robust, design, import_, export, devices):
    main.add_command(command)


@main.command("list", epilog=examples("cnnsim list", "cnnsim list --tag morphology", "cnnsim list --json"))
@click.option("--tag", help="Only templates of one family.")
@json_option
def list_(tag: str | None, as_json: bool) -> None:
    """List the templates of the library."""
    entries = [library.load(name) for name in library.names(tag)]
    if not entries:
        tags = sorted({tag for name in library.names() for tag in library.load(name).tags})
        raise InputError(f"no template has the tag {tag!r}; tags are {', '.join(tags)}")
    if as_json:
        print_json(
            [
                {"name": e.name, "summary": e.summary, "tags": e.tags, "reference": e.reference, "file": str(e.file)}
                for e in entries
            ]
        )
        return
    width = max(len(entry.name) for entry in entries)
    for entry in entries:
        own = "" if entry.shipped else f"  [{entry.file}]"
        click.echo(f"{entry.name:<{width}}  {entry.summary}{own}")


@main.command(epilog=examples("cnnsim show edge", "cnnsim show hole-filler --json"))
@click.argument("name")
@json_option
def show(name: str, as_json: bool) -> None:
    """Show a template: its numbers, its source and a worked example."""
    entry = library.load(name)
    if as_json:
        print_json(
            {
                "name": entry.name, "summary": entry.summary, "reference": entry.reference, "tags": entry.tags,
                "A": entry.template.A.tolist(), "B": entry.template.B.tolist(), "z": entry.template.z,
                "input": entry.input, "initial_state": entry.initial_state, "boundary": str(entry.boundary),
                "duration": entry.duration, "margin": entry.margin, "note": entry.note, "aliases": entry.aliases,
            }
        )  # fmt: skip
        return
    click.echo(f"{entry.name}: {entry.summary}\n")
    a, b = _matrix(entry.template.A), _matrix(entry.template.B)
    click.echo(_beside({"A": a, "B": b, "z": [f"{entry.template.z:g}"]}))
    click.echo(f"\ninput u        {entry.input}\ninitial state  {entry.initial_state}\nboundary       {entry.boundary}")
    click.echo(f"running time   {entry.duration}" + ("" if entry.duration == "settled" else " time constants"))
    if entry.margin is not None:
        click.echo(f"margin         {entry.margin:g}")
    click.echo(f"source         {entry.reference}")
    if entry.note:
        click.echo(f"note           {entry.note}")
    example = entry.examples[0]
    planes = {"input": example.input, "state": example.state, "mask": example.mask, "output": example.output}
    click.echo("\nExample\n" + _beside({name: to_ascii(plane) for name, plane in planes.items() if plane is not None}))


@main.command(epilog=examples("cnnsim explain edge", "cnnsim explain hole-filler --size 512x512"))
@click.argument("name")
@click.option("--size", default="64x64", show_default=True, help="Grid as ROWSxCOLS.")
@without_option
@json_option
def explain(name: str, size: str, without: tuple[str, ...], as_json: bool) -> None:
    """Print what the plan decides for a template, and why."""
    from cnnsim.plan import make_plan

    try:
        rows, cols = (int(part) for part in size.lower().split("x"))
    except ValueError as error:
        raise InputError(f"size {size!r}; ROWSxCOLS wanted, such as 64x64") from error
    entry = library.load(name)
    plan = make_plan(entry.template, (rows, cols), entry.boundary, duration=entry.duration, without=without)
    if as_json:
        print_json({"template": name, "method": plan.method, "step": plan.step, "decisions": plan.decisions})
    else:
        click.echo(plan.explain())


def _matrix(matrix: NDArray[np.float64]) -> list[str]:
    cells = [[f"{value:g}" for value in row] for row in matrix]
    width = max(len(cell) for row in cells for cell in row)
    return [" ".join(cell.rjust(width) for cell in row) for row in cells]


def _beside(blocks: dict[str, list[str]]) -> str:
    """Set blocks of lines side by side, each under its title."""
    height = max(len(block) for block in blocks.values())
    columns = []
    for title, block in blocks.items():
        width = max(len(title), *(len(line) for line in block))
        columns.append([line.ljust(width) for line in (title, *block, *[""] * (height - len(block)))])
    return "\n".join("   ".join(parts).rstrip() for parts in zip(*columns, strict=True))
