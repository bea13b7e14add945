"""Command `new`: writes a commented, runnable file of a scene, an array description or a detector."""

from pathlib import Path

import click

from cnnsim.support.command_line import examples
from cnnsim.support.files import check_name, write_text
from cnnsim.support.terminal import echo
from tactile.cli.new_texts import ARRAY, DETECTOR, SCENE


@click.command(
    epilog=examples(
        "tactile new scene my-touch", "tactile run my-touch.toml",
        "tactile new array my-skin -o skins/", "tactile emulate --array skins/my-skin.toml --scene my-touch.toml",
        "tactile new detector my-events", "tactile run my-touch.toml --program my-events.toml",
    )
)  # fmt: skip
@click.argument("kind", type=click.Choice(["scene", "array", "detector"]))
@click.argument("name")
@click.option("-o", "--output", type=click.Path(path_type=Path, file_okay=False), default=Path(), show_default=".",
              help="Folder for it.")  # fmt: skip
@click.option("--replace", is_flag=True, help="Write over a file that is there already.")
def new(kind: str, name: str, output: Path, replace: bool) -> None:
    """Write a commented file NAME.toml, which runs as it is.

    A scene is what touches simulated fingers; an array says what is on the other end of a cable; a
    detector is a program whose planes mean events.
    """
    path = output / f"{check_name(name, kind)}.toml"
    write_text(
        path, {"scene": SCENE, "array": ARRAY, "detector": DETECTOR}[kind].replace("NAME", name), replace=replace
    )
    echo(f"-> {path}")
    if kind == "scene":
        echo(f"to run it: tactile run {path} -o out/")
    elif kind == "detector":
        echo(f"to run it: tactile run SCENE.toml --program {path}; its planes: tactile planes")
    else:
        echo(f"to read a board: tactile live -p PORT -a {path}; PORT is one of `tactile ports`")
        echo(f"without one: tactile emulate --array {path} --scene SCENE.toml prints a port")
