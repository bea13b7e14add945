"""Ctrl-C while the program loads and compiles: it ends at once and in silence, since nothing is open yet.

An exception at any place of an import would end in a traceback, or be lost where a library swallows it.
"""

import signal
import threading
from collections.abc import Iterator
from contextlib import contextmanager


@contextmanager
def ends_at_once() -> Iterator[None]:
    """Let the system end the program on Ctrl-C during the block, unless somebody else has taken the signal."""
    if threading.current_thread() is not threading.main_thread():  # signals reach only that one
        yield
        return
    if signal.getsignal(signal.SIGINT) is not signal.default_int_handler:
        yield
        return
    signal.signal(signal.SIGINT, signal.SIG_DFL)
    try:
        yield
    finally:
        signal.signal(signal.SIGINT, signal.default_int_handler)
