"""Reading a port from a command: opening, stopping in good order, and printing how it went."""

import contextlib
import gc
import signal
import sys
import threading
from collections.abc import Callable, Iterator
from typing import TYPE_CHECKING, Any

from cnnsim.support import InputError
from cnnsim.support.terminal import console as screen
from cnnsim.support.terminal import echo
from tactile.serial.kept_memory import keep_memory
from tactile.serial.priority import raise_priority
from tactile.serial.time_slice import ask_for_short_slices

if TYPE_CHECKING:
    from tactile.cli.port.live import LiveOptions
    from tactile.finger import Finger
    from tactile.serial.session import Session
    from tactile.wire.description import Description


ENDS = [getattr(signal, name) for name in ("SIGINT", "SIGTERM", "SIGHUP") if hasattr(signal, name)]
"""Signals that end a reader in good order; Windows lacks the last."""


def warm_up(description: "Description", options: "LiveOptions") -> "list[Finger]":
    """Compile and refuse whatever there is to it before the port is opened; return the fingers, new."""
    from tactile import pipeline  # the machine is loaded only when it runs
    from tactile.wire.source import WireSource  # the same

    settings = options.settings(WireSource(description, ()), options.skin)
    pipeline.warm_up(description.arrays, description.modulus, settings)
    return pipeline.make_fingers(description.arrays, description.modulus, settings)


@contextlib.contextmanager
def stopping(stop: Callable[[], None]) -> Iterator[None]:
    """Let Ctrl-C, SIGTERM and the end of the terminal call ``stop`` instead of breaking off."""
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
def closing(session: "Session", as_json: bool, monitor: Any = None) -> Iterator[None]:
    """Close port and recording whatever happens, and print the counters; those of a ``monitor``, too."""
    recording = session.recording
    try:
        yield
    finally:
        session.close()
        counts, clock = session.counts, session.source.clock.plain()
        settled, unplugged = session.source.decoder.settled(), session.reader.unplugged
        summary: dict[str, Any] = {"counts": counts.plain(), "clock": clock, "settled": settled, "unplugged": unplugged}
        if monitor is not None:
            summary["latency"] = {name: value for name, value in monitor.status().items() if name.startswith("latency")}
        if recording is not None:
            recording.close(summary)
        if as_json:
            from tactile.cli.port.live import print_line  # only here

            print_line({"type": "end", **summary})
        else:
            times = "once" if unplugged == 1 else f"{unplugged} times"
            echo(f"{'' if recording is None else 'recorded: '}{counts}; unplugged {times}")
            if monitor is not None and monitor.meter.frames:
                usual, most, longest = (1e3 * value for value in summary["latency"].values())
                echo(f"{monitor.happened} events; latency {usual:.2f} ms, 99 % {most:.2f} ms, longest {longest:.2f} ms")
            if clock["residual_median_s"] is not None:
                usual, most = clock["residual_median_s"], clock["residual_max_s"]
                echo(f"device: {clock['drift_ppm']:+.1f} ppm; frames come {usual:.6f} s after it, longest {most:.6f}")
            for name, value in settled.items():
                echo(f"{name.replace('_', ' ')}: {'not told by the data' if value is None else value}")
    if recording is not None and recording.failed:
        raise InputError(recording.ended)


@contextlib.contextmanager
def viewing(monitor: Any, session: "Session", port: str, wanted: bool) -> Iterator[None]:
    """Show the live view on a terminal while something runs."""
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
    """Take commands typed while it runs."""
    with contextlib.suppress(OSError, ValueError):  # no standard input
        for line in sys.stdin:
            if line.strip() == "t":
                session.reader.ask_tare()
            elif line.strip() == "t!":
                session.reader.ask_tare(force=True)
            elif line.strip() == "q":
                session.stop()


def be_steady() -> None:
    """Let threads that are started from now on have their turn soon, also while other programs are busy.

    The interpreter hands over after 0.25 ms, where its default is 5 ms, and the collector of cyclic garbage leaves
    alone what all libraries have made so far: looking through that takes longer than a frame. Memory that was given
    back is kept.
    """
    ask_for_short_slices()
    raise_priority()
    keep_memory()
    sys.setswitchinterval(0.00025)
    gc.collect()
    gc.freeze()


def tell(line: dict[str, Any]) -> None:
    """Print an event, a tare, or what a program of the user's says, for people."""
    if line["type"] == "program":
        echo(f"{line['t_s']:10.3f}  {line['finger']}  {line['program']}: {line['outputs']}")
    if line["type"] == "tare":
        from tactile.cli.port.live import tare_words  # is loaded where there are tares

        echo(f"{line['t_s']:10.3f}  {line['finger']}  tare {tare_words(line)}")
    if line["type"] == "event_end":
        length = line["end_s"] - line["t_s"]
        echo(f"{line['end_s']:10.3f}  {line['finger']}  {line['words']} ends after {length:.3f} s")
    if line["type"] == "event":
        echo(f"{line['t_s']:10.3f}  {line['finger']}  {line['words']}")


def nothing(line: dict[str, Any]) -> None:
    """Print nothing: there is a view."""


def warn(text: str) -> None:
    """Tell people of trouble with the port."""
    echo(f"warning: {text}", err=True)


def warn_json(text: str) -> None:
    """Tell other programs of trouble with the port."""
    from tactile.cli.port.live import print_line  # only here

    print_line({"type": "warning", "text": text})
