"""Port commands: opening, orderly stopping, live view, and the summary at the end."""

import contextlib
import gc
import signal
import sys
import threading
from collections.abc import Callable, Iterator
from typing import TYPE_CHECKING, Any

from cnnsim.start import end_at_once, raise_again
from cnnsim.support import InputError
from cnnsim.support.terminal import console as screen
from cnnsim.support.terminal import echo, json_line

if TYPE_CHECKING:
    from tactile.finger import Finger
    from tactile.live_options import LiveOptions
    from tactile.output.publish import Publisher
    from tactile.serial.session import Session
    from tactile.wire.description import Description


ENDS = [getattr(signal, name) for name in ("SIGINT", "SIGTERM", "SIGHUP") if hasattr(signal, name)]
"""Signals that end a reader in an orderly way; Windows lacks the last."""


def warm_up(description: "Description", options: "LiveOptions") -> "list[Finger]":
    """Compile all loops and check all settings before the port is opened; return new fingers."""
    from tactile import pipeline  # imported when it runs
    from tactile.wire.source import WireSource  # the same

    settings = options.settings(WireSource(description, ()), options.skin)
    pipeline.warm_up(description.arrays, description.modulus, settings)
    return pipeline.make_fingers(description.arrays, description.modulus, settings)


@contextlib.contextmanager
def ends_at_once() -> Iterator[None]:
    """Let Ctrl-C end the program at once inside the block, while nothing is open, unless it is handled already."""
    if threading.current_thread() is not threading.main_thread():  # signals reach only that one
        yield
        return
    end_at_once()
    try:
        yield
    finally:
        raise_again()


@contextlib.contextmanager
def stopping(stop: Callable[[], None]) -> Iterator[None]:
    """Call ``stop`` on Ctrl-C, SIGTERM and the end of the terminal instead of aborting."""
    if threading.current_thread() is not threading.main_thread():  # signals reach only that one
        yield
        return
    before = {kind: signal.signal(kind, lambda *_: stop()) for kind in ENDS}
    try:
        yield
    finally:
        for kind, handler in before.items():
            signal.signal(kind, handler)


@contextlib.contextmanager
def closing(
    session: "Session", as_json: bool, monitor: Any = None, publisher: "Publisher | None" = None
) -> Iterator[None]:
    """Close port, recording and publisher in any case, and print the counters, also those of a ``monitor``."""
    try:
        yield
    finally:
        session.close()
        recording, summary = session.recording, session.summary()
        counts, clock = session.counts, summary["clock"]
        settled, unplugged = summary["settled"], summary["unplugged"]
        if monitor is not None:
            summary["latency"] = {name: value for name, value in monitor.status().items() if name.startswith("latency")}
        if publisher is not None:
            publisher.close()
            summary["published"] = {"sent": publisher.sent, "unsent": publisher.unsent}
        if recording is not None:
            recording.close(summary)
        if as_json:
            print_line({"type": "end", **summary})
        else:
            times = "once" if unplugged == 1 else f"{unplugged} times"
            echo(f"{'' if recording is None else 'recorded: '}{counts}; unplugged {times}")
            if monitor is not None and monitor.meter.frames:
                usual, most, longest = (1e3 * value for value in summary["latency"].values())
                echo(f"{monitor.happened} events; latency {usual:.2f} ms, 99 % {most:.2f} ms, longest {longest:.2f} ms")
            if publisher is not None:
                echo(f"published {publisher.sent} frames to {publisher.address}; {publisher.unsent} not sent")
            if clock["residual_median_s"] is not None:
                usual, most = clock["residual_median_s"], clock["residual_max_s"]
                echo(f"device: {clock['drift_ppm']:+.1f} ppm; frames come {usual:.6f} s after it, longest {most:.6f}")
            for name, value in settled.items():
                echo(f"{name.replace('_', ' ')}: {'not known from the data' if value is None else value}")
    if recording is not None and recording.failed:
        raise InputError(recording.ended)


@contextlib.contextmanager
def viewing(monitor: Any, session: "Session", port: str, wanted: bool) -> Iterator[None]:
    """Show the live view on a terminal inside the block."""
    if not wanted:
        yield
        return
    from rich.live import Live  # only for people

    from tactile.cli.port.view import LiveView  # the same

    def state() -> str:
        return f"{port}: {session.reader.why or session.check.trouble or 'open'}"

    with Live(LiveView(monitor, session.source.title, state), console=screen(), refresh_per_second=8, transient=True):
        yield


def listen(session: "Session") -> None:
    """Read commands from standard input: t (tare), t! (forced tare), q (stop)."""
    with contextlib.suppress(OSError, ValueError):  # no standard input
        for line in sys.stdin:
            if line.strip() == "t":
                session.reader.ask_tare()
            elif line.strip() == "t!":
                session.reader.ask_tare(force=True)
            elif line.strip() == "q":
                session.stop()


def be_steady() -> None:
    """Reduce thread latency: switch after 0.25 ms, not 5 ms, and exempt existing objects from garbage collection.

    A collection of all objects that the libraries have made takes longer than a frame.
    """
    sys.setswitchinterval(0.00025)
    gc.collect()
    gc.freeze()


def print_line(line: dict[str, Any]) -> None:
    """Print a line for other programs and flush it."""
    sys.stdout.write(json_line(line) + "\n")
    sys.stdout.flush()


def tare_words(line: dict[str, Any]) -> str:
    """Return a text on a change of the tare: reason, offset, and warnings."""
    return f"{line['why']}: {line['detail']}" if line["detail"] else str(line["why"])


def tell(line: dict[str, Any]) -> None:
    """Print an event, a tare or the output of a user's program as text."""
    if line["type"] == "program":
        echo(f"{line['t_s']:10.3f}  {line['finger']}  {line['program']}: {line['outputs']}")
    if line["type"] == "tare":
        echo(f"{line['t_s']:10.3f}  {line['finger']}  tare {tare_words(line)}")
    if line["type"] == "event_end":
        length = line["end_s"] - line["t_s"]
        echo(f"{line['end_s']:10.3f}  {line['finger']}  {line['words']} ends after {length:.3f} s")
    if line["type"] == "event":
        echo(f"{line['t_s']:10.3f}  {line['finger']}  {line['words']}")


def nothing(line: dict[str, Any]) -> None:
    """Print nothing, because there is a view."""


def warn(text: str, kind: str = "warning") -> None:
    """Print a warning or a note about the port."""
    echo(f"{kind}: {text}", err=True)


def warn_json(text: str) -> None:
    """Print a warning about the port as JSON."""
    print_line({"type": "warning", "text": text})
