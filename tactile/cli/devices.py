"""Commands for devices on serial ports: ports, emulate."""

import contextlib
import sys
import threading
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from cnnsim.support import InputError
from cnnsim.support.command_line import examples, print_json
from cnnsim.support.exclusive_file import lock, open_shut
from cnnsim.support.extras import need
from cnnsim.support.terminal import echo
from tactile.cli.options import ARRAY, FILE, JSON, PROTOCOL, chosen_description, write_new_text
from tactile.cli.port.console import be_steady, ends_at_once, stopping
from tactile.core.source import report_damage
from tactile.sources import open_source

if TYPE_CHECKING:
    from tactile.serial.emulator import Emulator


@click.command(epilog=examples("tactile ports"))
@JSON
def ports(as_json: bool) -> None:
    """List serial ports and the devices on them."""
    from tactile.serial.port import list_ports  # pyserial only where it is used

    rows = list_ports()
    if as_json:
        print_json(rows)
    for row in [] if as_json else rows:
        echo(f"{row['port']}  {row['what']}" + (f"  ({row['hint']})" if row["hint"] else ""))
    if not rows and not as_json:
        echo("no serial ports; `tactile emulate` makes one to try things with")


@click.command(
    epilog=examples(
        "tactile emulate --protocol reskin --scene examples/scenes/grip.toml --write-array array.toml",
        "tactile emulate --array hand.toml --scene grasp.npz --flip 1e-5 --unplug 10 --link hand.port",
        "tactile emulate --recording hand.mcap",
    )
)
@PROTOCOL
@ARRAY
@click.option("--scene", type=FILE, help="Scene (.toml) or recording (.npz, .csv) whose frames are sent.")
@click.option("--recording", type=FILE, help="Recording (.mcap) whose bytes are sent unchanged.")
@click.option("--write-array", type=FILE, help="File to write the matching array description to.")
@click.option("--link", type=FILE, help="Link to the port; its name stays the same after unplugging.")
@click.option("--loop", is_flag=True, help="Start again after the last frame.")
@click.option("--drop", type=float, default=0.0, help="Probability that a frame is lost.")
@click.option("--repeat", type=float, default=0.0, help="Probability that a frame is sent twice.")
@click.option("--flip", type=float, default=0.0, help="Probability that a bit is changed.")
@click.option("--split", is_flag=True, help="Send every frame in pieces.")
@click.option("--stall", type=float, default=0.0, help="Interval of pauses in sending [s]; 0: none.")
@click.option("--stall-for", type=float, default=0.2, show_default=True, help="Length of a pause [s].")
@click.option("--unplug", type=float, default=0.0, help="Interval at which the port disappears [s]; 0: never.")
@click.option("--unplug-for", type=float, default=0.5, show_default=True, help="Time until the port returns [s].")
@click.option("--seed", type=click.IntRange(0), default=0, help="Seed of the faults.")
@ends_at_once()
def emulate(
    protocol: str | None, array: Path | None, scene: Path | None, recording: Path | None, write_array: Path | None,
    link: Path | None, loop: bool, seed: int, **faults: Any,
) -> None:  # fmt: skip
    """Emulate a device on a virtual serial port.

    The port is printed; frames are sent at their times once a program opens it.
    """
    from tactile.serial.emulator import Emulator  # imported when used
    from tactile.serial.faults import Faults  # the same
    from tactile.wire.packets import check_form, emulated_description, packets  # the same
    from tactile.wire.source import UNPLUGGED  # the same

    if (scene is None) == (recording is None):
        raise click.UsageError("either --scene or --recording wanted")
    stream: Iterator[tuple[float, bytes]]
    kept = contextlib.ExitStack()
    if recording is not None:
        recorded = need("tactile.recording.reader", "an MCAP recording").open_recording(recording)
        report_damage(recording, recorded.mark)
        if not lock(kept.enter_context(open_shut(recording)), shared=True):
            raise InputError(f"{recording}: still being recorded; a closed recording wanted")
        description = recorded.description
        encoder = description.wire.encoder(description.options)
        stream = ((chunk.t * 1e-9, chunk.data) for chunk in recorded.chunks() if chunk.note != UNPLUGGED)
    else:
        assert scene is not None
        source = open_source(scene)
        if protocol is None and array is None:
            raise click.UsageError("--protocol or --array wanted")
        if array is None and write_array is None:
            check_form(str(protocol), source)
        description = chosen_description(protocol, array) if array else emulated_description(str(protocol), source)
        encoder = description.wire.encoder(description.options)
        stream = packets(description, source, loop, encoder)
    stop = threading.Event()
    be_steady()
    with kept, stopping(stop.set):
        device = Emulator(Faults(**faults), link, encoder, seed)
        kept.callback(device.pull)
        if write_array is not None:
            write_new_text(write_array, description.text)
        _introduce(device, array or write_array)
        device.run(stream, stop)
    echo(f"sent {device.sent} packets, lost {device.lost} for want of room", err=True)


def _introduce(device: "Emulator", array: Path | None) -> None:
    """Print the port of the device, and for people the command that reads it."""
    echo(device.port)
    sys.stdout.flush()
    if sys.stderr.isatty():
        form = array or "FILE, which --write-array FILE writes"
        echo(f"waiting for a reader: tactile live -p {device.port} -a {form}", err=True)
