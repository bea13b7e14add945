"""What the commands that read a port share: opening, stopping in good order, and saying how it went."""

import contextlib
import gc
import signal
import sys
import threading
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from cnnsim.support.errors import InputError
from tactile.serial.time_slice import ask_for_short_slices

if TYPE_CHECKING:
    from tactile.cli.live import LiveOptions
    from tactile.serial.session import Session
    from tactile.wire.description import Description


def chosen_description(protocol: str | None, array: Path | None) -> "Description":
    """Return what --array or --protocol name.

    Raises:
        InputError: the description is wrong, or the protocol needs one.
    """
    from tactile.wire.description_file import default_description, read_description  # NumPy is slow to import

    if array is None:
        if protocol is None:
            raise click.UsageError("--array or --protocol wanted")
        return default_description(protocol)
    description = read_description(array)
    if protocol not in (None, description.wire.name):
        raise click.UsageError(f"--protocol {protocol}, but {array} says {description.wire.name}")
    return description


def kept_calibration(path: Path | None, description: "Description") -> str | None:
    """Return the text of a calibration's file, to be kept in a recording; None without one.

    Raises:
        InputError: the file cannot be read or is wrong; no calibration, and readings whose unit is no quantity.
    """
    if path is None:
        description.check_calibrated()
        return None
    from tactile.calibration.file import load_calibration  # SciPy's splines are slow to import

    load_calibration(path)  # so that messages name the file
    return path.read_text(encoding="utf-8")


def mcap(path: Path) -> Path:
    """Return the path of a recording to write.

    Raises:
        InputError: another suffix than .mcap.
    """
    if path.suffix != ".mcap":
        raise InputError(f"{path}: suffix {path.suffix!r}, .mcap wanted")
    return path


def write_text(path: Path, text: str) -> None:
    """Write a small file.

    Raises:
        InputError: it cannot be written.
    """
    try:
        path.write_text(text, encoding="utf-8")
    except OSError as error:
        raise InputError(f"cannot write {path}: {error.strerror}") from error


def check_thresholds(chosen: dict[str, Any]) -> None:
    """Refuse thresholds that contradict each other."""
    if chosen["sign_code"] and (chosen["dead_band"], chosen["hysteresis"]) != (None, None):
        raise click.UsageError("--sign-code has no dead band; leave out --dead-band and --hysteresis")
    if chosen["hysteresis"] is not None and chosen["dead_band"] is None:
        raise click.UsageError("--hysteresis needs a --dead-band, in the unit of the quantity")


def warm_up(description: "Description", options: "LiveOptions") -> None:
    """Compile and refuse whatever there is to it before the port is opened."""
    from tactile import pipeline  # the machine is loaded only when it runs
    from tactile.cli.user_program import UserProgram  # the same

    settings = options.settings(description.arrays, options.skin)
    own = [] if options.program is None else [UserProgram(options.program, settings.shear, options.backend, nothing)]
    pipeline.warm_up(description.arrays, description.modulus, settings, own)


def opened(make: "Callable[[], Session]", recording: Any) -> "Session":
    """Open the session; a port that does not open leaves a recording that says so by being empty but whole."""
    try:
        return make()
    except InputError:
        if recording is not None:
            recording.close({})
        raise


@contextlib.contextmanager
def stopping(stop: Callable[[], None]) -> Iterator[None]:
    """Let Ctrl-C and SIGTERM call ``stop`` instead of breaking off."""
    if threading.current_thread() is not threading.main_thread():  # signals reach only that one
        yield
        return
    before = {kind: signal.signal(kind, lambda *_: stop()) for kind in (signal.SIGINT, signal.SIGTERM)}
    try:
        yield
    finally:
        for kind, handler in before.items():
            signal.signal(kind, handler)


@contextlib.contextmanager
def closing(session: "Session", recording: Any, as_json: bool, monitor: Any = None) -> Iterator[None]:
    """Close port and recording whatever happens, and print the counters; those of a ``monitor``, too."""
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
            from tactile.cli.live import print_line  # only here

            print_line({"type": "end", **summary})
        else:
            times = "once" if unplugged == 1 else f"{unplugged} times"
            click.echo(f"{'' if recording is None else 'recorded: '}{counts}; unplugged {times}")
            if monitor is not None and monitor.meter.frames:
                usual, most, longest = (1e3 * value for value in summary["latency"].values())
                click.echo(
                    f"{monitor.happened} events; latency {usual:.2f} ms, 99 % {most:.2f} ms, longest {longest:.2f} ms"
                )
            if clock["residual_median_s"] is not None:
                usual, most = clock["residual_median_s"], clock["residual_max_s"]
                click.echo(
                    f"device: {clock['drift_ppm']:+.1f} ppm; frames come {usual:.6f} s after it, longest {most:.6f}"
                )
            for name, value in settled.items():
                click.echo(f"{name.replace('_', ' ')}: {'not told by the data' if value is None else value}")
    if recording is not None and recording.failed:
        raise InputError(recording.failed)


@contextlib.contextmanager
def viewing(monitor: Any, session: "Session", port: str, wanted: bool) -> Iterator[None]:
    """Show the live view on a terminal while something runs."""
    if not wanted:
        yield
        return
    from rich.live import Live  # only for people

    from tactile.cli.view import LiveView  # the same

    def state() -> str:
        return f"{port}: {session.reader.why or 'open'}"

    with Live(LiveView(monitor, session.source.title, state), refresh_per_second=8, transient=True):
        yield


def listen(session: "Session") -> None:
    """Take commands typed while it runs."""
    with contextlib.suppress(OSError, ValueError):  # no standard input
        for line in sys.stdin:
            if line.strip() == "t":
                session.reader.ask_tare()
            elif line.strip() == "q":
                session.stop()


def be_steady() -> None:
    """Let threads that are started from now on have their turn soon, also while other programs are busy.

    The interpreter hands over after 0.25 ms, where its default is 5 ms, and the collector of cyclic garbage leaves
    alone what all libraries have made so far: looking through that takes longer than a frame.
    """
    ask_for_short_slices()
    sys.setswitchinterval(0.00025)
    gc.collect()
    gc.freeze()


def tell(line: dict[str, Any]) -> None:
    """Print an event, a tare, or what a program of the user's says, for people."""
    if line["type"] == "program":
        click.echo(f"{line['t_s']:10.3f}  {line['finger']}  {line['program']}: {line['outputs']}")
    if line["type"] == "tare":
        click.echo(f"{line['t_s']:10.3f}  {line['finger']}  tare {line['why']}")
    if line["type"] == "event":
        click.echo(f"{line['t_s']:10.3f}  {line['finger']}  {line['words']}")


def nothing(line: dict[str, Any]) -> None:
    """Print nothing: there is a view."""
