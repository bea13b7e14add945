"""Options of a command that serves a page, and the serving until Ctrl-C."""

from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING

import click

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


def need_server() -> None:
    """Import the libraries of the extra.

    Raises:
        InputError: one is not installed.
    """
    from cnnsim.support.extras import need

    for module in ("starlette", "uvicorn", "websockets"):
        need(module, "the studio", "studio")


def serve(
    make_model: Callable[[], "Model"], page: Path, name: str, port: int, host: str, no_browser: bool,
    begin: Callable[[], None] = lambda: None,
) -> None:  # fmt: skip
    """Serve a page until Ctrl-C; print its address, ``begin`` what takes time, and open the browser."""
    import webbrowser  # it brings modules that no other command needs

    from cnnsim.studio.server import make_server

    server, listening, address = make_server(make_model, page, host, port)
    if host not in ("127.0.0.1", "localhost", "::1"):
        say(f"warning: everyone who reaches {host} and knows the address below can use this page", err=True)
    echo(f"studio of {name}: {address}")
    begin()  # who opens the address meanwhile waits
    if not no_browser:
        webbrowser.open(address)
    server.run(sockets=[listening])
