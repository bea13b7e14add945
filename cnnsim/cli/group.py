"""The command line `cnnsim`: the group that gathers the commands."""

from pathlib import Path

import click

from cnnsim import library
from cnnsim.cli.accuracy import accuracy
from cnnsim.cli.design import design
from cnnsim.cli.devices import devices
from cnnsim.cli.examples import examples_command
from cnnsim.cli.explain import explain
from cnnsim.cli.formats import export, import_
from cnnsim.cli.library import list_
from cnnsim.cli.new import new
from cnnsim.cli.program import program
from cnnsim.cli.robust import robust
from cnnsim.cli.run import run
from cnnsim.cli.show import show
from cnnsim.cli.studio import studio
from cnnsim.cli.sweep import sweep
from cnnsim.cli.trace import trace
from cnnsim.cli.train import train
from cnnsim.support.command_line import CommandGroup


@click.group(cls=CommandGroup, context_settings={"help_option_names": ["-h", "--help"]})
@click.version_option(package_name="cellular-wave-touch")
@click.option(
    "--library", "folders", type=click.Path(path_type=Path), multiple=True,
    help="A folder of your own templates; of several the last comes first.",
)  # fmt: skip
@click.pass_context
def main(context: click.Context, folders: tuple[Path, ...]) -> None:
    """Run templates and programs of a cellular neural network universal machine."""
    context.with_resource(library.using(*folders))


for command in (
    list_,
    show,
    explain,
    accuracy,
    run,
    program,
    trace,
    robust,
    studio,
    sweep,
    new,
    design,
    train,
    import_,
    export,
    devices,
    examples_command("cnnsim"),
):
    main.add_command(command)
