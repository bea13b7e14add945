"""Progress of long computations: a watcher, which is a bar on the terminal of a command or below a notebook's cell."""

import sys
from collections.abc import Iterator
from contextlib import contextmanager
from threading import RLock, Timer, current_thread, main_thread
from time import monotonic
from typing import Any, Protocol

PATIENCE = 1.0
"""Seconds of a command before a bar is shown."""


class Watcher(Protocol):
    """A callback for progress."""

    def __call__(self, share: float | None, text: str) -> None:
        """Report the ``share`` of the work that is done (None if the total is unknown), and a short text."""

    def over(self) -> None:
        """Report that the work is done."""


class _Watched:
    by: Watcher | None = None
    cell: "TerminalBar | None" = None
    shell: Any = None


def watcher() -> Watcher | None:
    """Return the present watcher, in a notebook without one the bar of the running cell, else None."""
    return _Watched.by or _cell_bar()


def _cell_bar() -> "TerminalBar | None":
    shell = getattr(sys.modules.get("IPython"), "get_ipython", lambda: None)()
    if shell is None or not hasattr(shell, "kernel") or current_thread() is not main_thread():
        return None
    if _Watched.shell is not shell:
        _Watched.shell = shell
        shell.events.register("post_run_cell", _end_cell)
    if _Watched.cell is None:
        _Watched.cell = TerminalBar()
    return _Watched.cell


def _end_cell(_result: Any) -> None:
    if _Watched.cell is not None:
        _Watched.cell.over()
    _Watched.cell = None


@contextmanager
def watched_by(new: Watcher | None) -> Iterator[None]:
    """Set the watcher in a block; None for no watcher, when another bar is on the same terminal."""
    before, _Watched.by = _Watched.by, new
    try:
        yield
    finally:
        if new is not None:
            new.over()
        _Watched.by = before


class TerminalBar:
    """A bar on stderr with elapsed and remaining time, shown once a command has taken `PATIENCE` seconds."""

    def __init__(self, patience: float = PATIENCE) -> None:
        self._bar: Any = None
        self._from, self._task, self._share = monotonic() + patience, 0, 0.0
        self._lock = RLock()
        self._timer: Timer | None = None
        self._last: tuple[float | None, str] = None, ""

    def __call__(self, share: float | None, text: str) -> None:
        """See `Watcher`."""
        with self._lock:
            self._show(share, text)

    def _late(self) -> None:
        """Show the last report once the patience is over, in a thread: the next report may come much later."""
        with self._lock:
            if self._timer is not None and self._bar is None:
                self._from = 0.0
                self._show(*self._last)

    def _show(self, share: float | None, text: str) -> None:
        if self._bar is None:
            if (early := self._from - monotonic()) > 0:
                self._last = share, text
                if self._timer is None:
                    self._timer = Timer(early, self._late)
                    self._timer.daemon = True
                    self._timer.start()
                return
            self._bar, self._task = _bar(), 0
            self._bar.start()
            self._task = self._bar.add_task(text, total=None)
        if share is not None and share < self._share:
            self._bar.reset(self._task)
        self._share = share or 0.0
        total = None if share is None else 1.0
        self._bar.update(self._task, completed=self._share, total=total, description=text)

    def over(self) -> None:
        """See `Watcher`."""
        with self._lock:
            if self._timer is not None:
                self._timer.cancel()
            if self._bar is not None:
                self._bar.stop()
            self._bar, self._timer, self._share = None, None, 0.0


def _bar() -> Any:
    from rich.progress import (  # slow to import, and only needed for long work
        BarColumn,
        Progress,
        TextColumn,
        TimeElapsedColumn,
        TimeRemainingColumn,
    )

    from cnnsim.support.terminal import console  # the same

    columns = TextColumn("{task.description}", markup=False), BarColumn(20), TimeElapsedColumn(), TimeRemainingColumn()
    return Progress(*columns, console=console(err=True), transient=True, redirect_stdout=False, redirect_stderr=False)


def terminal_bar() -> Watcher | None:
    """Return a bar if stderr is a terminal, else None."""
    return TerminalBar() if sys.stderr.isatty() else None
