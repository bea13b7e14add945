"""Ctrl-C while a command loads and compiles: it ends at once, because nothing is open yet."""

import threading
from collections.abc import Iterator
from contextlib import contextmanager

from cnnsim.start import end_at_once, raise_again


@contextmanager
def ends_at_once() -> Iterator[None]:
    """Let Ctrl-C end the program at once inside the block, unless the signal is handled already."""
    if threading.current_thread() is not threading.main_thread():  # signals reach only that one
        yield
        return
    end_at_once()
    try:
        yield
    finally:
        raise_again()
