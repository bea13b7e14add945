"""Port check: warnings about an open port that is silent or whose bytes do not fit the description."""

import time
from collections.abc import Callable
from dataclasses import replace

from tactile.wire.description import Description
from tactile.wire.source import PLUGGED, Chunk, WireSource

PATIENCE = 2.5
"""[s] Time before the first warning."""
STRAY = 0.2
"""Share of bytes outside frames above which a warning is issued."""


class PortCheck:
    """Watches the bytes of a port. ``trouble`` is the present warning; `say` receives each warning once.

    ``source`` returns the source that decodes its bytes.
    """

    def __init__(
        self, port: str, description: Description, source: Callable[[], WireSource], say: Callable[[str], None]
    ) -> None:
        self.trouble = ""
        self._port, self._description, self._source, self._say = port, description, source, say
        self._begin()

    def _begin(self) -> None:
        self._came = 0
        self._since = self._last = time.monotonic()
        self._before = replace(self._source().counts)

    def see(self, chunk: Chunk) -> None:
        """Register a chunk on its way to the decoder."""
        if chunk.note == PLUGGED:
            self._begin()
        elif chunk.data:
            self._came += len(chunk.data)
            self._last = time.monotonic()

    def look(self, is_open: bool, over: bool = False) -> None:
        """Issue new warnings; ``over``: at once, because nothing more will come."""
        now = time.monotonic()
        trouble = ""
        if is_open and (over or now - self._since > PATIENCE):
            trouble = self._found(now, over)
        if trouble and not self.trouble:
            self._say(trouble)
        self.trouble = trouble

    def _found(self, now: float, over: bool) -> str:
        counts, wire = self._source().counts, self._description.wire
        good, unfit, stray = (
            getattr(counts, name) - getattr(self._before, name) for name in ("good", "unfit", "resynchronised")
        )
        if not self._came:
            return (
                f"port {self._port} is open, but nothing comes: is the device on, is it this port, does it send at"
                f" {self._description.baudrate} baud without being asked?"
            )
        if not over and now - self._last > PATIENCE:
            return f"port {self._port} is open, but nothing has come for {now - self._last:.0f} s"
        shapes = ", ".join(f"{rows} x {cols}" for rows, cols in self._description.options.shapes)
        if unfit > good:
            found = self._source().decoder.unfit
            return f"{unfit} whole frames of {wire.name} are of another shape than described ({shapes} taxels): {found}"
        if not good:
            return (
                f"{self._came} bytes came and no frame of {wire.name} in them: another protocol, baud rate"
                f" ({self._description.baudrate}) or number of taxels ({shapes}) than the device has"
            )
        if stray > STRAY * self._came:
            return (
                f"{stray} of {self._came} bytes belong to no frame of {wire.name}: the device has another number of"
                f" taxels than {shapes}, or the cable is bad"
            )
        return ""
