"""The command `studio`: a page in the browser that shows the taxels, loads, codes and events of an array."""

import contextlib
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from cnnsim.studio.command import need_server, page_options, serve
from cnnsim.support.command_line import examples
from cnnsim.support.notices import Notices
from cnnsim.support.terminal import echo
from tactile.cli.options import (
    ARRAY,
    FILE,
    LAYOUT,
    PROTOCOL,
    check_thresholds,
    chosen_description,
    detection,
    kept_calibration,
)
from tactile.cli.port import console
from tactile.sources import is_file_source

if TYPE_CHECKING:
    from tactile.studio.feed import Feed


@click.command(
    epilog=examples(
        "tactile studio examples/scenes/grip.toml", "tactile studio /dev/ttyACM0 -a hand.toml --record hand.mcap"
    )
)
@click.argument("source")
@PROTOCOL
@ARRAY
@LAYOUT
@click.option("--record", "output", type=FILE, help="Recording of the record button (.mcap).")
@click.option("--replace", is_flag=True, help="Let --record overwrite an existing recording.")
@click.option("--calibration", type=FILE, help="Gains, depth and correction of a skin.")
@detection
@click.option("--window", type=int, help="Frames a texture figure averages [128].")
@click.option("--floor", type=float, help="Normal signal below which texture figures are not valid.")
@page_options
def studio(
    source: str, protocol: str | None, array: Path | None, layout: Path | None, output: Path | None,
    replace: bool, calibration: Path | None, port: int, host: str, no_browser: bool, **chosen: Any,
) -> None:  # fmt: skip
    """Show an array at work in the browser.

    SOURCE is a serial port, which needs --array or --protocol, or what `tactile run` takes: a scene, a recording or a
    table with a --layout. Ctrl-C ends it.
    """
    check_thresholds(chosen)
    need_server()
    from tactile.studio import PAGE  # imported when used
    from tactile.studio.model import ArrayModel  # the same

    page = port, host, no_browser
    if is_file_source(Path(source)):
        if output is not None or protocol is not None or array is not None:
            raise click.UsageError(f"{source} is a file; --record, --protocol and --array are for ports")
        feed = _of_file(Path(source), layout, calibration, chosen)
        serve(lambda: ArrayModel(feed), PAGE, feed.source.title, *page, feed.start)
        return
    if layout is not None:
        raise click.UsageError(f"--layout is for tables of other programs, and there is no file {source}")
    from tactile.live_options import LiveOptions  # imported when used
    from tactile.studio.port_link import PortLink  # the same

    description = chosen_description(protocol, array)
    options = LiveOptions(calibration=kept_calibration(calibration, description), **chosen)
    links: list[PortLink] = []
    with contextlib.ExitStack() as at_end:

        def begin() -> None:
            links.append(link := PortLink(source, description, options, output, replace))
            at_end.enter_context(console.stopping(link.session.stop))  # the server passes the signal on at its end
            at_end.callback(lambda: echo(link.close()))
            link.feed.start()

        serve(lambda: ArrayModel(links[0].feed, links[0]), PAGE, description.title, *page, begin)


def _of_file(path: Path, layout: Path | None, calibration: Path | None, chosen: dict[str, Any]) -> "Feed":
    from tactile.opened import RunChoices, open_for_run  # slow to import
    from tactile.settings import PipelineOptions  # the same
    from tactile.studio.feed import Feed  # the same

    opened = open_for_run(path, RunChoices(PipelineOptions(**chosen), calibration=calibration, layout=layout))
    for line in (*opened.notes, opened.forces):
        if line:
            Notices.say(f"note: {line}")
    return Feed(opened.source, opened.settings, compiling=True)
