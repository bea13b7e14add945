"""The command `new`: writes a commented, valid file of a template or a program."""

import re
from pathlib import Path

import click

from cnnsim.library.new import new_text
from cnnsim.support import InputError
from cnnsim.support.command_line import examples
from cnnsim.support.files import write_text
from cnnsim.support.terminal import echo

NAME = re.compile(r"[a-z0-9]+(-[a-z0-9]+)*")
"""Valid names of templates and programs."""


@click.command(
    epilog=examples(
        "cnnsim new template my-edge -o my-library/",
        "cnnsim new program my-rim -o my-library/",
        "cnnsim --library my-library list",
    )
)
@click.argument("kind", type=click.Choice(["template", "program"]))
@click.argument("name")
@click.option("-o", "--output", type=click.Path(path_type=Path, file_okay=False), default=Path(), show_default=".",
              help="Folder of the library; programs go into its folder programs.")  # fmt: skip
@click.option("--replace", is_flag=True, help="Write over a file that is there already.")
def new(kind: str, name: str, output: Path, replace: bool) -> None:
    """Write a commented file of a new template or program.

    The file NAME.toml runs without changes.
    """
    if not NAME.fullmatch(name):
        raise InputError(f"name {name!r}; small letters, digits and hyphens wanted, such as my-edge")
    path = output / ("programs" if kind == "program" else "") / f"{name}.toml"
    write_text(path, new_text(kind, name), replace=replace)
    echo(f"-> {path}")
    call = (
        f"run {name} scan.png -o out.png" if kind == "template" else f"program {name} --input picture=scan.png -o out/"
    )
    echo(f"to run it: cnnsim --library {output} {call}")
