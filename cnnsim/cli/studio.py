"""The command `studio`: a page in the browser where a template runs on a picture, and can be changed as it runs."""

from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING

import click

from cnnsim.cli.pictures import binary_option
from cnnsim.support.command_line import examples
from cnnsim.support.terminal import echo, say

if TYPE_CHECKING:
    from cnnsim.studio.message import Model


def page_options(command: Callable[..., None]) -> Callable[..., None]:
    """Give a command the options of a page."""
    for option in (
        click.option("--no-browser", is_flag=True, help="Print the address only."),
        click.option(
            "--host", default="127.0.0.1", show_default=True, help="Address to listen on; others may reach it then."
        ),
        click.option(
            "--port", type=click.IntRange(0, 65535), default=0, help="Port to listen on; a free one if not given."
        ),
    ):
        command = option(command)
    return command


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


def need_server() -> None:
    """Import the libraries of the extra.

    Raises:
        InputError: one is not installed.
    """
    from cnnsim.support.extras import need

    for module in ("starlette", "uvicorn", "websockets"):
        need(module, "the studio", "studio")


def serve(make_model: Callable[[], "Model"], page: Path, name: str, port: int, host: str, no_browser: bool) -> None:
    """Serve a page until Ctrl-C; print its address and open the browser."""
    import webbrowser  # it brings modules that no other command needs

    from cnnsim.studio.server import make_server

    server, listening, address = make_server(make_model, page, host, port)
    if host not in ("127.0.0.1", "localhost", "::1"):
        say(f"warning: everyone who reaches {host} and knows the address below can use this page", err=True)
    echo(f"studio of {name}: {address}")
    if not no_browser:
        webbrowser.open(address)
    server.run(sockets=[listening])
