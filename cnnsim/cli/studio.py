"""The command `studio`: a page in the browser where a template runs on a picture, and can be changed as it runs."""

from pathlib import Path

import click

from cnnsim.cli.pictures import binary_option
from cnnsim.studio.command import need_server, page_options, serve
from cnnsim.support.command_line import examples


@click.command(
    epilog=examples(
        "cnnsim studio", "cnnsim studio hole-filler scan.png --binary", "cnnsim studio trigger-wave --port 8765"
    )
)
@click.argument("template", default="hole-filler")
@click.argument("picture", required=False, type=click.Path(path_type=Path))
@binary_option
@page_options
def studio(template: str, picture: Path | None, binary: bool, port: int, host: str, no_browser: bool) -> None:
    """Show a template at work in the browser.

    TEMPLATE of the library runs on PICTURE, or on one that you draw. Weights, boundary, cell and scheme can be changed
    as it runs. Ctrl-C ends it.
    """
    need_server()
    from cnnsim.studio import PAGE
    from cnnsim.studio.session import Session
    from cnnsim.studio.setup import given_setup

    setup = given_setup(template, picture, binary=binary)
    Session(setup)  # what cannot run is an error of the command
    serve(lambda: Session(setup), PAGE, setup.entry.name, port, host, no_browser)
