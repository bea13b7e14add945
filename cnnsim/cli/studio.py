"""The command `studio`: a page in the browser where a template runs on a picture, and can be changed as it runs."""

from pathlib import Path

import click

from cnnsim.cli.pictures import binary_option
from cnnsim.support.command_line import examples
from cnnsim.support.terminal import echo, say


@click.command(
    epilog=examples(
        "cnnsim studio", "cnnsim studio hole-filler scan.png --binary", "cnnsim studio trigger-wave --port 8765"
    )
)
@click.argument("template", default="hole-filler")
@click.argument("picture", required=False, type=click.Path(path_type=Path))
@binary_option
@click.option("--port", type=click.IntRange(0, 65535), default=0, help="Port to listen on; a free one if not given.")
@click.option("--host", default="127.0.0.1", show_default=True, help="Address to listen on; others may reach it then.")
@click.option("--no-browser", is_flag=True, help="Print the address only.")
def studio(template: str, picture: Path | None, binary: bool, port: int, host: str, no_browser: bool) -> None:
    """Show a template at work in the browser.

    TEMPLATE of the library runs on PICTURE, or on one that you draw. Weights, boundary, cell and scheme can be changed
    as it runs. Ctrl-C ends it.
    """
    import webbrowser  # it brings modules that no other command needs

    from cnnsim.support.extras import need

    for module in ("starlette", "uvicorn", "websockets"):
        need(module, "the studio", "studio")
    from cnnsim.studio import PAGE
    from cnnsim.studio.server import make_server
    from cnnsim.studio.session import Session
    from cnnsim.studio.setup import given_setup

    setup = given_setup(template, picture, binary=binary)
    Session(setup)  # what cannot run is an error of the command

    server, listening, address = make_server(lambda: Session(setup), PAGE, host, port)
    if host not in ("127.0.0.1", "localhost", "::1"):
        say(f"warning: everyone who reaches {host} and knows the address below can use this page", err=True)
    echo(f"studio of {setup.entry.name}: {address}")
    if not no_browser:
        webbrowser.open(address)
    server.run(sockets=[listening])
