"""Command line of the tactile layer: the group of all commands."""

import warnings
from typing import Any

import click

from cnnsim.cli.examples import examples_command
from cnnsim.support.command_line import CommandGroup
from cnnsim.support.terminal import echo
from cnnsim.sweep.command import sweep_command
from tactile.cli.accuracy import accuracy
from tactile.cli.calibrate import calibrate
from tactile.cli.devices import emulate, ports
from tactile.cli.explain import explain
from tactile.cli.files import convert, new
from tactile.cli.layout import layout
from tactile.cli.learn import learn
from tactile.cli.planes import codes, planes
from tactile.cli.run import run
from tactile.cli.score import score
from tactile.cli.stream import live, record, replay
from tactile.cli.studio import studio
from tactile.cli.texture import texture

SWEEPS = {"scenes": "tactile.sweeps.scenes", "labelled": "tactile.sweeps.labelled"}
"""Kind of sweep -> its module."""


@click.group(cls=CommandGroup, context_settings={"help_option_names": ["-h", "--help"]})
@click.version_option(package_name="cellular-wave-touch")
def main() -> None:
    """Turn frames of three-axial taxel arrays into events, located loads and texture figures."""
    shown = warnings.showwarning

    def show(message: Warning | str, category: type[Warning], *where: Any, **more: Any) -> None:
        if category.__module__.startswith("tactile."):  # of a scene, not of code
            echo(f"note: {message}", err=True)
        else:
            shown(message, category, *where, **more)

    warnings.showwarning = show


for command in (
    run, score, learn, sweep_command(SWEEPS, "tactile", "grips.toml", "seed,frames"), texture, planes, codes, new,
    calibrate, explain, accuracy, ports, emulate, record, replay, convert, layout, live, studio,
    examples_command("tactile"),
):  # fmt: skip
    main.add_command(command)
