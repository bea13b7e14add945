"""Compile notice: tells a terminal, once, that loops are being compiled, if that takes more than a second."""

import time
from collections.abc import Callable
from threading import Timer
from typing import Any

_PATIENCE = 1.0
"""Seconds of compiling, all in all, before something is said."""


class Notice:
    """Listens to numba's compiler and calls ``say`` once, when it has worked for a second."""

    def __init__(self, say: Callable[[], None], patience: float = _PATIENCE) -> None:
        self._say, self._left, self._depth, self._since = say, patience, 0, 0.0
        self._timer: Timer | None = None

    def on_start(self, _event: Any = None) -> None:
        """The compiler starts, perhaps from within itself."""
        self._depth += 1
        if self._depth == 1 and self._left > 0:
            self._since, self._timer = time.monotonic(), Timer(self._left, self._now)
            self._timer.daemon = True
            self._timer.start()

    def on_end(self, _event: Any = None) -> None:
        """It has done."""
        self._depth -= 1
        if self._depth == 0 and self._timer is not None:
            self._timer.cancel()
            self._left -= time.monotonic() - self._since

    def _now(self) -> None:
        self._left = -1.0
        self._say()


class Terminal:
    """Where to say it: ``wanted`` is set by command lines whose stderr is a terminal."""

    wanted = False


def announce(where: str) -> None:
    """Say it on stderr when loops that are kept in ``where`` are compiled, if a command line has asked for it."""
    if not Terminal.wanted:
        return
    from numba.core import event

    def say() -> None:
        from cnnsim.support.echo import console  # click and rich are slow to import

        console(err=True).print(f"compiling, once; kept in {where}", style="dim", soft_wrap=True, highlight=False)

    class Listener(Notice, event.Listener):  # type: ignore[misc]  # numba says nothing of its types
        pass

    event.register("numba:compiler_lock", Listener(say))
