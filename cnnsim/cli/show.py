"""The command `show`: a template's numbers, its source and a worked example as text."""

import click

from cnnsim import library
from cnnsim.cli.run import json_option
from cnnsim.library.entry import Example, LibraryEntry
from cnnsim.network import Table, Template, layered
from cnnsim.support import Floats
from cnnsim.support.command_line import examples, print_json
from cnnsim.support.echo import echo
from cnnsim.support.picture import to_ascii


@click.command(epilog=examples("cnnsim show edge", "cnnsim show hole-filler --json"))
@click.argument("name")
@json_option
def show(name: str, as_json: bool) -> None:
    """Show a template: its numbers, its source and a worked example."""
    from cnnsim.library.write_terms import template_keys  # only for JSON and terms

    entry = library.load(name)
    if as_json:
        keys = ("name", "summary", "reference", "tags", "input", "initial_state", "duration", "margin", "note")
        facts = {key: getattr(entry, key) for key in (*keys, "aliases")}
        facts |= {"boundary": str(entry.boundary), "cell": _cell(entry)}
        print_json(facts | template_keys(entry.network))
        return
    echo(f"{entry.name}: {entry.summary}")
    network = layered(entry.network)
    for number, (layer, time) in enumerate(zip(network.layers, network.time_constants, strict=True)):
        echo("" if len(network.layers) == 1 else f"\nlayer {number}, time constant {time:g}")
        echo(_numbers(layer))
    for title, value in _facts(entry).items():
        echo(f"{title:<15}{value}")
    if entry.examples:
        echo("\nExample\n" + _drawn(entry.examples[0]))
    else:
        echo("\nNo worked example: nobody has checked this file.")


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
        function = "" if term.table is None else f", f: {_table(term.table)}"
        shown = _beside({f"term of {term}{function}": _matrix(term.weights)}) if term.weights.ndim == 2 else ""
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


def _matrix(matrix: Floats) -> list[str]:
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
