"""The most memory that a process and all it started take together."""

import os
import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

SHARE = 0.02
"""Of a core, what looking may take: the system goes through all pages, 50 ms of processes with gigabytes, and those
wait for it that want more."""


@contextmanager
def peak_memory() -> Iterator[list[float]]:
    """Give a list whose entry is the largest memory of this process and its children together [bytes], sampled."""
    peak, over = [0.0], threading.Event()

    def watch() -> None:
        took = 0.0
        while not over.wait(max(0.05, took / SHARE)):
            begun = time.perf_counter()
            peak[0] = max(peak[0], sum(map(_own_memory, family())))
            took = time.perf_counter() - begun

    thread = threading.Thread(target=watch)
    thread.start()
    try:
        yield peak
    finally:
        over.set()
        thread.join()


def family() -> list[int]:
    """Return this process and all that descend from it."""
    parents: dict[int, list[int]] = {}
    for entry in Path("/proc").glob("[0-9]*"):
        try:
            fields = (entry / "stat").read_text().rpartition(")")[2].split()
        except OSError:
            continue
        parents.setdefault(int(fields[1]), []).append(int(entry.name))
    found = [os.getpid()]
    for process in found:
        found += parents.get(process, [])
    return found


def _own_memory(process: int) -> float:
    """Return the memory of a process without what it shares with others counted twice."""
    try:
        lines = Path(f"/proc/{process}/smaps_rollup").read_text().splitlines()
    except OSError:
        return 0.0
    return 1024.0 * sum(int(line.split()[1]) for line in lines if line.startswith("Pss:"))


def command_of(process: int) -> bytes:
    """Return the command line of a process, empty where it has gone."""
    try:
        return Path(f"/proc/{process}/cmdline").read_bytes()
    except OSError:
        return b""
