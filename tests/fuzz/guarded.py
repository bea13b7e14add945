"""Files judged one after the other in a child of limited memory; one that hangs or ends it costs itself alone."""

import json
import os
import resource
import select
import signal
import time
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path

SLOW = 5.0
"""[s] of the processor that no file may take."""
STUCK = 60.0
"""[s] that nothing may wait for, on a machine however busy."""
LARGE = 1000 * 2**20
"""Bytes that no file may take beyond what the readers themselves need."""
LIMIT = 3000 * 2**20
"""Bytes beyond which the system gives none: what is asked for in vain is no harm, but a fault where it is not told."""
TOGETHER = 1000
"""Files that a child judges before another takes its place: what they leave behind does not add up without end."""


@dataclass
class Verdict:
    """What is wrong with how a file was taken, in words; the processor's time [s]; whether it was ``read``."""

    faults: list[str] = field(default_factory=list)
    seconds: float = 0.0
    read: bool = False


class Guard:
    """The child, and what watches it: its memory, the processor's time and the time that a file takes."""

    def __init__(
        self, judge: Callable[[Path], Verdict], slow: float = SLOW, stuck: float = STUCK, large: int = LARGE
    ) -> None:
        self._judge, self._slow, self._stuck, self._large = judge, slow, stuck, large
        self._child, self._left = 0, 0

    def judge(self, path: Path) -> Verdict:
        """Have a file judged; a child that does not come back is killed, and its end is the verdict."""
        if self._child == 0:
            self._start()
        self._left -= 1
        os.write(self._to, f"{path}\n".encode())
        begun, spent, line = time.monotonic(), _spent(self._child), b""
        while not line.endswith(b"\n"):
            if select.select([self._back], [], [], 0.5)[0]:
                part = os.read(self._back, 1 << 16)
                if not part:
                    return Verdict([f"the process ended with {self._end()}"])
                line += part
                continue
            seconds, waited = _spent(self._child) - spent, time.monotonic() - begun
            if seconds > self._slow or waited > self._stuck:
                self._end()
                return Verdict([f"not done after {seconds:.1f} s of the processor, {waited:.0f} s"], seconds)
        told = Verdict(**json.loads(line))
        if told.seconds > self._slow:
            told.faults.append(f"{told.seconds:.1f} s")
        if self._left == 0 or told.faults:
            self._end()
        return told

    def close(self) -> None:
        """End the child."""
        if self._child:
            self._end()

    def _start(self) -> None:
        requests, self._to = os.pipe()
        self._back, replies = os.pipe()
        self._left = TOGETHER
        self._child = os.fork()
        if self._child == 0:
            os.close(self._to)
            os.close(self._back)
            try:
                self._serve(requests, replies)
            finally:
                os._exit(70)
        os.close(requests)
        os.close(replies)

    def _serve(self, requests: int, replies: int) -> None:
        used = int(Path("/proc/self/statm").read_text().split()[0]) * resource.getpagesize()
        _, most = resource.getrlimit(resource.RLIMIT_AS)
        if most == resource.RLIM_INFINITY:
            resource.setrlimit(resource.RLIMIT_AS, (used + LIMIT, used + LIMIT))
        for line in os.fdopen(requests):
            before, begun = _peak(), time.process_time()  # a busy machine is not the file's fault
            told = self._judge(Path(line.rstrip("\n")))
            told.seconds = time.process_time() - begun
            if _peak() - before > self._large:
                told.faults.append(f"{(_peak() - before) / 1e6:.0f} MB")
            os.write(replies, json.dumps(vars(told)).encode() + b"\n")
        os._exit(0)

    def _end(self) -> int:
        """Kill the child, and return how it ended, minus the signal if one ended it."""
        for pipe in (self._to, self._back):
            os.close(pipe)
        os.kill(self._child, signal.SIGKILL)
        _, status = os.waitpid(self._child, 0)
        self._child = 0
        return os.waitstatus_to_exitcode(status)


def _peak() -> int:
    """Return the most memory that this process has had [bytes]."""
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * 1024


def _spent(process: int) -> float:
    """Return the processor's time of a process [s]."""
    fields = Path(f"/proc/{process}/stat").read_text(encoding="ascii").rpartition(")")[2].split()
    return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")
