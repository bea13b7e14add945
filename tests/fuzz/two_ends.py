"""The two ends of a long run: a device on a pseudo-terminal, a reader of it, and other busy processes."""

import os
import signal
import subprocess
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

from tests.kits.processes import code_line, command_line, ended

SCENE = """
title = "endurance"
rate_hz = {hz}
duration_s = {seconds}
[cover]
youngs_modulus_mpa = 2.4
"""
FINGER = """
[[finger]]
name = "{name}"
rows = {rows}
cols = {cols}
pitch_mm = 1.0
depth_mm = 1.0
[[load]]
finger = "{name}"
path = [[0.5, -0.3, 0.2, 0.0, 0.0, 0.0], [1.0, -0.3, 0.2, 0.1, -0.3, 0.5], [2.5, 1.4, 0.2, 0.1, -0.3, 0.5],
        [3.0, 1.4, 0.2, 0.0, 0.0, 0.0]]
"""
FINGERS = {"papillarray": [("left", 3, 3), ("right", 3, 3)], "reskin": [("tip", 1, 5)], "lowiek": [("tip", 4, 8)]}
"""Name, rows and columns of the arrays of each protocol; one of 8 x 8 for the others."""


@contextmanager
def emulator(
    folder: Path, hz: float, seconds: float, *more: str, protocol: str = "native", fingers: int = 1
) -> "Iterator[Callable[[], str]]":
    """Run a device that loops over the scene, and give what ends it and returns its last words.

    Its port is ``folder / skin``.
    """
    scene = SCENE.format(hz=hz, seconds=float(seconds))
    for name, rows, cols in FINGERS.get(protocol, [(f"tip{n}", 8, 8) for n in range(fingers)]):
        scene += FINGER.format(name=name, rows=rows, cols=cols)
    (folder / "scene.toml").write_text(scene, encoding="utf-8")
    arguments = ["emulate", "--protocol", protocol, "--scene", str(folder / "scene.toml"), "--link",
                 str(folder / "skin"), "--write-array", str(folder / "array.toml"), *more]  # fmt: skip
    # a session of its own: where the kernel shares the processors out by session, a device takes none of the reader's
    with ended(subprocess.Popen(
        command_line("tactile", *arguments), stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True,
        start_new_session=True,
    )) as process:  # fmt: skip
        assert process.stdout is not None
        process.stdout.readline()
        with suppress(OSError, AttributeError):  # as if it had a processor of its own, where that is allowed
            os.sched_setscheduler(process.pid, os.SCHED_RR, os.sched_param(1))

        def end() -> str:
            process.send_signal(signal.SIGINT)
            return process.communicate()[1].strip()

        yield end


def reader(folder: Path, name: str, *more: str, command: str = "live") -> "subprocess.Popen[str]":
    """Start a reader that writes JSON lines and a recording."""
    record = ["-o" if command == "record" else "--record", str(folder / f"{name}.mcap")]
    arguments = [command, "-p", str(folder / "skin"), "-a", str(folder / "array.toml"), "--json", *record, *more]
    return subprocess.Popen(
        command_line("tactile", *arguments), stdout=subprocess.PIPE, stderr=subprocess.PIPE,
        stdin=subprocess.DEVNULL, text=True,
    )  # fmt: skip


def peak_mib(process: "subprocess.Popen[str]") -> float:
    """Return the most memory a running process ever had [MiB]."""
    status = Path(f"/proc/{process.pid}/status").read_text(encoding="ascii")
    return int(next(line for line in status.splitlines() if line.startswith("VmHWM")).split()[1]) / 1024


def processor_seconds(process: "subprocess.Popen[str]") -> float:
    """Return the processor time [s] that a running process has had, in its own code and the kernel's."""
    fields = Path(f"/proc/{process.pid}/stat").read_text(encoding="ascii").rpartition(")")[2].split()
    return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")


@contextmanager
def metronome(period: float = 0.005) -> "Iterator[Callable[[], float]]":
    """Yield the longest delay [s] of a timed thread of highest priority: the pauses of the machine."""
    latest, done = [0.0], threading.Event()

    def beat() -> None:
        with suppress(OSError, AttributeError):  # not allowed here: then it says less
            os.sched_setscheduler(threading.get_native_id(), os.SCHED_RR, os.sched_param(2))
        while not done.is_set():
            begun = time.perf_counter()
            time.sleep(period)
            latest[0] = max(latest[0], time.perf_counter() - begun - period)

    thread = threading.Thread(target=beat)
    thread.start()
    try:
        yield lambda: latest[0]
    finally:
        done.set()
        thread.join()


@contextmanager
def busy(count: int) -> Iterator[None]:
    """So many other processes that compute all the time."""
    others = [subprocess.Popen(code_line("while True: pass")) for _ in range(count)]
    try:
        yield
    finally:
        for other in others:
            other.kill()
            other.wait()
