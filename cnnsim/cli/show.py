"""The command `show`: numbers, source and a worked example of a template; steps of a program."""

from shutil import get_terminal_size

import click

from cnnsim import library
from cnnsim.cli.run import json_option
from cnnsim.library.entry import Example, LibraryEntry
from cnnsim.network import Table, Template, layered
from cnnsim.program.file import find_program
from cnnsim.program.numbering import step_rows
from cnnsim.program.program import Program
from cnnsim.support import Floats
from cnnsim.support.command_line import examples, print_json
from cnnsim.support.pictures.picture import to_ascii
from cnnsim.support.terminal import echo, hanging, say_table


@click.command(epilog=examples("cnnsim show edge", "cnnsim show hole-filler --json", "cnnsim show slip-front"))
@click.argument("name")
@json_option
def show(name: str, as_json: bool) -> None:
    """Show the content of a template or a program.

    Of a template the numbers, the source and a worked example; of a program inputs, outputs and steps.

    NAME is one of the library, or a file; where a template and a program share it, programs/NAME is the program.
    """
    from cnnsim.library.write import template_keys  # only for JSON and terms

    program = find_program(name)
    if program is not None:
        _show_program(program, as_json)
        return
    entry = library.load(name)
    if as_json:
        keys = ("name", "summary", "reference", "tags", "input", "initial_state", "duration", "margin", "note")
        facts = {key: getattr(entry, key) for key in (*keys, "aliases")}
        facts |= {"boundary": str(entry.boundary), "cell": _cell(entry)}
        print_json(facts | template_keys(entry.network))
        return
    echo(hanging("", f"{entry.name}: {entry.summary}", 0))
    network = layered(entry.network)
    for number, (layer, time) in enumerate(zip(network.layers, network.time_constants, strict=True)):
        echo("" if len(network.layers) == 1 else f"\nlayer {number}, time constant {time:g}")
        echo(_numbers(layer))
    say_table([(title, str(value)) for title, value in _facts(entry).items()])
    if entry.examples:
        echo("\nExample\n" + _drawn(entry.examples[0]))
    else:
        echo("\nNo worked example: the file is not tested.")


def _show_program(program: Program, as_json: bool) -> None:
    facts = {
        "name": program.name, "summary": program.summary, "reference": program.reference, "inputs": program.inputs,
        "outputs": program.outputs, "parameters": dict(program.parameters), "keep": dict(program.keep),
        "memory": dict(program.memory),
        "file": str(program.path),
        "steps": [{"number": number, "does": does, "to": to} for number, does, to in step_rows(program.steps)],
    }  # fmt: skip
    if as_json:
        print_json(facts)
        return
    echo(hanging("", f"{program.name}: {program.summary}", 0) + "\n")
    kinds = {kind: [n for n, k in program.memory.items() if k == kind] for kind in ("lam", "llm", "wire")}
    may_be_set = [f"{name} = {value}" for name, value in program.parameters.items()]
    kept = [f"{name} = {value:g}" for name, value in program.keep.items()]
    said = {
        "takes": program.inputs, "gives": program.outputs, "may be set": may_be_set, "keeps": kept,
        "analog planes": kinds["lam"], "logic planes": kinds["llm"], "registers": kinds["wire"],
        "source": [program.reference], "file": [] if program.shipped else [str(program.path)],
    }  # fmt: skip
    say_table([(title, ", ".join(values)) for title, values in said.items() if any(values)])
    echo("\nSteps")
    say_table([(number, f"{does}{' -> ' if to else ''}{to}") for number, does, to in step_rows(program.steps)])


def _facts(entry: LibraryEntry) -> dict[str, object]:
    """Return titles and values of the lines below the numbers."""
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
    """Return the planes of an example side by side; layers or frames are below each other."""
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
    """Return titled blocks of lines side by side, or below each other on a narrow terminal."""
    wide = sum(max(len(title), *map(len, block)) + 3 for title, block in blocks.items()) - 3
    if len(blocks) > 1 and wide > get_terminal_size().columns:
        return "\n".join(_beside({title: block}) for title, block in blocks.items())
    height = max(len(block) for block in blocks.values())
    columns = []
    for title, block in blocks.items():
        width = max(len(title), *(len(line) for line in block))
        columns.append([line.ljust(width) for line in (title, *block, *[""] * (height - len(block)))])
    return "\n".join("   ".join(parts).rstrip() for parts in zip(*columns, strict=True))
