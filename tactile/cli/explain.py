"""Command `explain`: the parts of a scene with their size and time."""

from pathlib import Path

import click

from cnnsim.support.command_files import claim
from cnnsim.support.command_line import examples, print_json, replace_option
from cnnsim.support.terminal import console, printable
from tactile.cli.options import FILE, JSON

FULL = 1000
"""Columns where the output is no terminal: no line of a scene is longer, and nothing is cut."""


@click.command(
    epilog=examples(
        "tactile explain examples/scenes/grip.toml",
        "tactile explain scene.toml --json",
        "tactile explain examples/scenes/textures.toml --write chosen.toml",
    )
)
@click.argument("scene", type=FILE)
@click.option("--write", type=FILE, help="Keep the effects chosen by effects = 'auto' in this scene file.")
@replace_option
@JSON
def explain(scene: Path, write: Path | None, as_json: bool) -> None:
    """Show the size and time of each part of a scene.

    Effects that SCENE does not use are listed with the change that they would make.
    """
    from tactile.simulator.explain import explain_file  # not for --help

    claim(write)
    explanation = explain_file(scene, write)
    if as_json:
        print_json(
            {
                "title": explanation.title,
                "peak": explanation.peak,
                "unit": explanation.unit,
                "fingers": explanation.lines,
                "parts": [vars(part) for part in explanation.parts],
                "notes": explanation.notes,
            }
        )
        return
    from rich.text import Text  # the same
    from rich.tree import Tree  # the same

    tree = Tree(
        Text.assemble((printable(explanation.title), "bold"), f"  peak {explanation.peak:.3g} {explanation.unit}")
    )
    for line in explanation.lines:
        tree.add(line)
    on = tree.add("on: size in the signal relative to the peak, time per frame")
    off = tree.add("off: what adding it would change, relative to the peak (at the strength given, or a typical one)")
    for part in explanation.parts:
        size = "" if part.name == "contacts" else "<= " * part.at_most + f"{part.size:.2g}"
        text = f"{part.name:<20} {size:>9}"
        if part.on:
            on.add(Text.assemble((text, "green"), f"  {_time(part.seconds):>9}  ", (printable(part.what), "dim")))
        else:
            off.add(Text.assemble(f"{text}             ", (printable(part.what), "dim")) if part.what else text)
    for note in explanation.notes:
        tree.add(note)
    console(FULL).print(tree)


def _time(seconds: float | None) -> str:
    return "" if seconds is None else f"{seconds * 1e6:.3g} us"
