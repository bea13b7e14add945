"""Commands on the bytes of a port or of its recording: record, live, replay."""

import sys
import threading
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from cnnsim import backends
from cnnsim.support.command_line import examples
from cnnsim.support.extras import need
from cnnsim.support.terminal import echo
from tactile.cli.options import (
    ARRAY,
    FILE,
    LAYOUT,
    PROTOCOL,
    Finite,
    check_thresholds,
    chosen_description,
    detection,
    kept_calibration,
    new_mcap,
)
from tactile.cli.port import console
from tactile.cli.port.outputs import VIEWS, LiveOutputs, OutputChoices
from tactile.core.source import damage_text, report_damage
from tactile.settings import PipelineOptions

if TYPE_CHECKING:
    from tactile.recording.writer import Recording
    from tactile.serial.session import Session

PORT = click.option("--port", "-p", required=True, help="Port to read; `tactile ports` lists them.")
SECONDS = click.option("--seconds", type=Finite(0, min_open=True), help="Stop after this time [s].")
ONCE = click.option("--once", is_flag=True, help="Stop when the port is unplugged instead of waiting for it.")
REPLACE = click.option("--replace", is_flag=True, help="Overwrite an existing recording.")
JSON = click.option("--json", "as_json", is_flag=True, help="Print JSON lines for other programs.")
EVERY = click.option("--every-frame", is_flag=True, help="Print a JSON line for each frame, too; with --json.")


def _session_and_recording() -> "tuple[type[Session], type[Recording]]":
    """Return both classes.

    Raises:
        InputError: a library of the extra ``serial`` is not installed.
    """
    session = need("tactile.serial.session", "a serial port").Session
    return session, need("tactile.recording.writer", "an MCAP recording").Recording


@click.command(epilog=examples("tactile record -p /dev/ttyACM0 -a hand.toml -o hand.mcap"))
@PORT
@PROTOCOL
@ARRAY
@click.option("-o", "--output", type=FILE, required=True, help="Recording to write (.mcap).")
@SECONDS
@ONCE
@REPLACE
@JSON
@console.ends_at_once()
def record(
    port: str, protocol: str | None, array: Path | None, output: Path, seconds: float | None, once: bool,
    replace: bool, as_json: bool,
) -> None:  # fmt: skip
    """Record bytes and frames of a port until Ctrl-C."""
    session_of, recording = _session_and_recording()
    description = chosen_description(protocol, array)
    into = partial(recording, new_mcap(output, replace), description, {"port": port}, replace=replace)
    console.be_steady()
    ending, warn = threading.Event(), console.warn_json if as_json else console.warn
    with console.stopping(ending.set):
        session = session_of(port, description, into, seconds=seconds, once=once, stopped=ending, warn=warn)
        with console.closing(session, as_json):
            following = 10**9
            for _ in session.source:
                if session.source.arrival >= following:
                    following = session.source.arrival + 10**9
                    session.note("/counts", session.source.arrival, {"counts": session.counts.plain()})
                    if sys.stderr.isatty() and not as_json:
                        echo(session.counts, over=True, err=True)


@click.command(
    epilog=examples(
        "tactile live -p /dev/ttyACM0 -a hand.toml --record hand.mcap",
        "tactile live -p /dev/ttyACM0 --protocol papillarray --json",
        "tactile live -p /dev/ttyACM0 -a hand.toml --publish udp://127.0.0.1:9000",
    )
)
@PORT
@PROTOCOL
@ARRAY
@click.option("--record", "output", type=FILE, help="Recording to write (.mcap).")
@click.option(
    "--tare", type=click.Choice(["auto", "manual", "off"]), default="auto", show_default=True,
    help="Renew the offset automatically from still, unloaded frames, only on request (t), or never.",
)  # fmt: skip
@click.option("--calibration", type=FILE, help="Gains, depth and correction of a skin, as `tactile calibrate` writes.")
@detection
@click.option("--window", type=int, help="Frames a texture figure averages [128].")
@click.option("--floor", type=float, help="Normal signal below which texture figures are not valid.")
@click.option("--backend", type=click.Choice(backends.NAMES), help="Where the machine runs [cpu].")
@SECONDS
@ONCE
@REPLACE
@JSON
@EVERY
@click.option("--publish", metavar="URL", help="Send each frame as a datagram to udp://HOST:PORT.")
@click.option("--msgpack", is_flag=True, help="Send datagrams as MessagePack instead of JSON.")
@click.option("--drawable", is_flag=True, help="Add messages that Foxglove, Lichtblick and RViz draw to --record.")
@click.option("--view", type=click.Choice(VIEWS), help="Show the frames in a viewer on this machine (extras).")
@console.ends_at_once()
def live(
    port: str, protocol: str | None, array: Path | None, output: Path | None, seconds: float | None, once: bool,
    replace: bool, as_json: bool, every_frame: bool, publish: str | None, msgpack: bool, drawable: bool,
    view: str | None, calibration: Path | None, **chosen: Any,
) -> None:  # fmt: skip
    """Run the pipeline on frames as they arrive. Typing t and Return requests a tare, t! forces
    it under load, q or Ctrl-C ends.
    """
    from tactile.cli.port.live import LiveMonitor  # the same
    from tactile.live_options import LiveOptions

    check_thresholds(chosen)
    choices = OutputChoices(every_frame, publish, msgpack, drawable, view)
    choices.check(output is not None)
    as_json = as_json or every_frame
    session_of, recording = _session_and_recording()
    description = chosen_description(protocol, array)
    options = LiveOptions(calibration=kept_calibration(calibration, description), **chosen)
    into = None
    if output is not None:
        origin = {"port": port, "choices": options.text()}
        into = partial(recording, new_mcap(output, replace), description, origin, replace=replace)
    outputs = LiveOutputs(choices, description.arrays)
    fingers = console.warm_up(description, options)
    console.be_steady()
    screen = sys.stdout.isatty() and not as_json
    say = console.print_line if as_json else console.nothing if screen else console.tell
    ending, warn = threading.Event(), console.warn_json if as_json else console.warn
    with console.stopping(ending.set):
        session = session_of(port, description, into, seconds, once, ending, warn)
        monitor = LiveMonitor(session.source, say, session.now, session.note, lambda: session.counts)
        threading.Thread(target=console.listen, args=(session,), daemon=True).start()
        closing = console.closing(session, as_json, monitor, outputs.publisher)
        with closing, outputs.open(session) as sinks, console.viewing(monitor, session, port, screen):
            monitor.run(options, fingers, sinks)


@click.command(
    epilog=examples(
        "tactile replay hand.mcap",
        "tactile replay hand.mcap --paced --json",
        "tactile replay examples/grasp.npz --speed 5",
    )
)
@click.argument("recording", type=FILE)
@click.option("--paced", is_flag=True, help="At the recording's own speed instead of as fast as possible.")
@click.option("--speed", type=Finite(0, min_open=True), help="As --paced, faster by this factor.")
@detection
@LAYOUT
@JSON
def replay(
    recording: Path, paced: bool, speed: float | None, layout: Path | None, as_json: bool, **chosen: Any
) -> None:
    """Run the pipeline on a recording as if it were live.

    The bytes of a port (.mcap) go through the decoder, with the settings of the live run. Of other recordings, and of
    tables of other programs, the frames are taken, with the settings of `tactile run`.

    Options of thresholds and programs take the place of those of the live run, and these of those in the array file.
    """
    from tactile.cli.port.replayed import replay_bytes, replay_frames, wire_recording  # imported when used

    check_thresholds(chosen)
    say = console.print_line if as_json else console.tell
    pace, options = speed or (1.0 if paced else None), PipelineOptions(**chosen)
    recorded = wire_recording(recording)
    if recorded is None:
        monitor, counts, ended = *replay_frames(recording, layout, options, pace, say), {}
    else:
        report_damage(recording, recorded.mark)
        monitor, counts = replay_bytes(recorded, str(recording), options, pace, say)
        ended = {"complete": recorded.complete, "state": recorded.mark}
    if as_json:
        console.print_line(monitor.status() | {"type": "end"} | ended)
        return
    echo(f"{monitor.meter.frames} frames, {monitor.happened} events; {counts}")
    if recorded is not None and recorded.mark:
        echo(damage_text(recording, recorded.mark))
