"""The commands about the library: list it, show a template, explain how it would be computed."""

import click
import numpy as np
from numpy.typing import NDArray

from cnnsim import library
from cnnsim.cli.run import json_option, without_option
from cnnsim.library import folders
from cnnsim.library.entry import Example, LibraryEntry
from cnnsim.library.explain import explain as explanation
from cnnsim.network.layers import layered
from cnnsim.network.table import Table
from cnnsim.network.template import Template
from cnnsim.support.command_line import examples, print_json
from cnnsim.support.errors import InputError
from cnnsim.support.picture import to_ascii


@click.command(
    "list",
    epilog=examples("cnnsim list", "cnnsim list --tag morphology", "cnnsim list --programs", "cnnsim list --json"),
)
@click.option("--tag", help="Only templates of one family.")
@click.option("--programs", is_flag=True, help="The programs instead of the templates, with what they take and give.")
@json_option
def list_(tag: str | None, programs: bool, as_json: bool) -> None:
    """List the templates of the library, or its programs."""
    if programs:
        if tag is not None:
            raise InputError("programs have no tags; --tag goes with templates")
        _list_programs(as_json)
        return
    entries = [library.load(name) for name in library.names(tag)]
    if not entries:
        tags = sorted({tag for name in library.names() for tag in library.load(name).tags})
        raise InputError(f"no template has the tag {tag!r}; tags are {', '.join(tags)}")
    if as_json:
        keys = ("name", "summary", "tags", "reference", "margin")
        print_json([{key: getattr(entry, key) for key in keys} | {"file": str(entry.file)} for entry in entries])
        return
    width = max(len(entry.name) for entry in entries)
    for entry in entries:
        own = "" if entry.shipped else f"  [{entry.file}{'' if entry.examples else ', no worked example'}]"
        margin = f"  (small margin: {entry.margin:g})" if entry.margin is not None and entry.margin < 0.5 else ""
        click.echo(f"{entry.name:<{width}}  {entry.summary}{margin}{own}")


def _list_programs(as_json: bool) -> None:
    from cnnsim.program.file import load_program

    found = {name: load_program(path) for name, path in folders.programs().items()}
    if as_json:
        keys = ("summary", "inputs", "outputs")
        print_json(
            [{"name": n} | {key: getattr(p, key) for key in keys} | {"file": str(p.path)} for n, p in found.items()]
        )
        return
    width = max(map(len, found))
    for name, program in found.items():
        own = "" if program.path and program.path.is_relative_to(library.folder()) else f"  [{program.path}]"
        click.echo(f"{name:<{width}}  {program.summary}{own}")
        click.echo(f"{'':<{width}}    {', '.join(program.inputs)} -> {', '.join(program.outputs)}")


@click.command(epilog=examples("cnnsim show edge", "cnnsim show hole-filler --json"))
@click.argument("name")
@json_option
def show(name: str, as_json: bool) -> None:
    """Show a template: its numbers, its source and a worked example."""
    from cnnsim.library.write_terms import template_keys  # only for JSON and terms

    entry = library.load(name)
    if as_json:
        keys = (
            "name",
            "summary",
            "reference",
            "tags",
            "input",
            "initial_state",
            "duration",
            "margin",
            "note",
            "aliases",
        )
        facts = {key: getattr(entry, key) for key in keys} | {"boundary": str(entry.boundary), "cell": _cell(entry)}
        print_json(facts | template_keys(entry.network))
        return
    click.echo(f"{entry.name}: {entry.summary}")
    network = layered(entry.network)
    for number, (layer, time) in enumerate(zip(network.layers, network.time_constants, strict=True)):
        click.echo("" if len(network.layers) == 1 else f"\nlayer {number}, time constant {time:g}")
        click.echo(_numbers(layer))
    for title, value in _facts(entry).items():
        click.echo(f"{title:<15}{value}")
    if entry.examples:
        click.echo("\nExample\n" + _drawn(entry.examples[0]))
    else:
        click.echo("\nNo worked example: nobody has checked this file.")


@click.command(epilog=examples("cnnsim explain edge", "cnnsim explain hole-filler --size 512x512 --without sleep"))
@click.argument("name")
@click.option("--size", default="64x64", show_default=True, help="Grid as ROWSxCOLS.")
@without_option
@json_option
def explain(name: str, size: str, without: tuple[str, ...], as_json: bool) -> None:
    """Print what the plan decides for a template, and why."""
    try:
        rows, cols = (int(part) for part in size.lower().split("x"))
    except ValueError as error:
        raise InputError(f"size {size!r}; ROWSxCOLS wanted, such as 64x64") from error
    found = explanation(name, (rows, cols), without=without)
    if as_json:
        plan, known = found.plan, found.guaranteed
        facts = {"template": name, "method": plan.method, "step": plan.step, "decisions": plan.decisions}
        print_json(facts | {"guaranteed_time": known.time, "why": known.why, "assuming": known.assuming})
    else:
        click.echo(str(found))


def _facts(entry: LibraryEntry) -> dict[str, object]:
    """The lines below the numbers; what a template does not have has no line."""
    settled = entry.duration == "settled"
    lines = {
        "input u": entry.input,
        "initial state": entry.initial_state,
        "cell": None if entry.cell.model == "chua-yang" and entry.cell.characteristic is None else _cell(entry),
        "boundary": entry.boundary,
        "running time": entry.duration if settled else f"{entry.duration} time constants",
        "a new frame": None if entry.frame_time is None else f"every {entry.frame_time:g} time constants",
        "margin": None if entry.margin is None else f"{entry.margin:g}",
        "source": entry.reference,
        "note": entry.note or None,
        "file": None if entry.shipped else entry.file,
    }
    return {title: value for title, value in lines.items() if value is not None}


def _cell(entry: LibraryEntry) -> str:
    characteristic = entry.cell.characteristic
    return entry.cell.model + ("" if characteristic is None else f" with the characteristic {characteristic}")


def _table(table: Table) -> str:
    if table.kind == "linear":
        return "lines between " + ", ".join(f"({a:g}, {v:g})" for a, v in zip(table.at, table.values, strict=True))
    values = [f"{value:g}" for value in table.values]
    return "steps " + "".join(f"{v}, from {a:g} on " for v, a in zip(values, table.at, strict=False)) + values[-1]


def _numbers(template: Template) -> str:
    blocks = {"A": _matrix(template.A), "B": _matrix(template.B), "z": [f"{template.z:g}"]}
    text = _beside(blocks) + "\n"
    for term in template.terms:
        times = "" if term.times is None else f" times ({term.times})"
        delay = f", {term.delay:g} time constants ago" if term.delay else ""
        layer = "" if term.layer is None else f" of layer {term.layer}"
        table = "" if term.table is None else f", through {_table(term.table)}"
        weights = np.array(term.weights)
        shown = (
            _beside({f"term of {term.of}{layer}{times}{delay}{table}": _matrix(weights)}) if weights.ndim == 2 else ""
        )
        text += "\n" + shown + "\n"
    return text


def _drawn(example: Example) -> str:
    """An example's planes side by side; the layers or frames of one stand below each other."""
    blocks = {}
    for name in ("input", "state", "mask", "output"):
        plane = getattr(example, name)
        if plane is not None:
            planes = plane if plane.ndim == 3 else plane[None]
            lines = [line for one in planes for line in (*to_ascii(one), "")]
            blocks[name] = lines[:-1]
    return _beside(blocks)


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
