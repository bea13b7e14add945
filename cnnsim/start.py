"""Start of a command line: Ctrl-C, SIGTERM and SIGHUP end it with one line, also while libraries are imported.

An exception within an import would end in a traceback, or be lost where a library catches it. This module imports few
modules, because until it has run, the interpreter handles Ctrl-C.
"""

import os
import signal
import sys
from importlib import import_module
from types import FrameType

ADDRESS_SPACE = 1_000_000_000
"""Bytes of address space (``ulimit -v``) that a command needs: libraries that lack it abort or spin."""
LAYERS = "default", "safe", "threadsafe", "forksafe", "tbb", "omp", "workqueue"
"""Threading layers of numba."""


class Stop:
    """How the process ends: ``code`` is 128 and the number of the last signal; ``at_once`` without cleanup."""

    code = 130
    at_once = False


def start(group: str, prog_name: str | None = None) -> None:
    """Import the module of a group of commands, and run its ``main``."""
    end_at_once()
    for kind in (signal.SIGTERM, getattr(signal, "SIGHUP", signal.SIGTERM)):  # Windows lacks the last
        if signal.getsignal(kind) is signal.SIG_DFL:
            signal.signal(kind, _as_interrupt)
    if fault := environment_fault():
        os.write(2, f"Error: {fault}\n".encode())
        sys.exit(2)
    os.environ["MPLBACKEND"] = "agg"  # commands draw into files; a backend inherited from a notebook may be missing
    import_module(group).main(prog_name=prog_name)


def environment_fault() -> str | None:
    """Return what is wrong with the environment of the process, in one line; None if libraries can use it."""
    threads = os.environ.get("NUMBA_NUM_THREADS", "1")
    if not (threads.isascii() and threads.isdecimal() and int(threads) > 0):
        return f"NUMBA_NUM_THREADS={threads!a}; a whole number above 0 wanted"
    layer = os.environ.get("NUMBA_THREADING_LAYER", "default")
    if layer not in LAYERS:
        return f"NUMBA_THREADING_LAYER={layer!a}; one of {', '.join(LAYERS)} wanted"
    if (switch := os.environ.get("NUMBA_DISABLE_JIT", "0")) != "0":
        return f"NUMBA_DISABLE_JIT={switch!a}; 0 wanted, as the loops run compiled only"
    try:
        import resource
    except ImportError:  # Windows
        return None
    most = resource.getrlimit(resource.RLIMIT_AS)[0]
    if most != resource.RLIM_INFINITY and most < ADDRESS_SPACE:
        return f"{most / 1e6:.0f} MB of address space (ulimit -v); {ADDRESS_SPACE / 1e6:.0f} MB at least wanted"
    return None


def end_at_once() -> None:
    """Let Ctrl-C end the process without cleanup, as nothing is open yet; another handler of SIGINT is kept."""
    Stop.at_once = True
    if signal.getsignal(signal.SIGINT) is signal.default_int_handler:
        signal.signal(signal.SIGINT, _end)


def raise_again() -> None:
    """Let Ctrl-C raise KeyboardInterrupt again, so that open files and devices are closed."""
    Stop.at_once = False
    if signal.getsignal(signal.SIGINT) is _end:
        signal.signal(signal.SIGINT, signal.default_int_handler)


def leave() -> None:
    """End the process without cleanup, with the code of `Stop`; a hidden cursor is shown again."""
    if sys.stderr.isatty():
        os.write(sys.stderr.fileno(), b"\x1b[?25h\n")
    os._exit(Stop.code)


def _end(number: int, _frame: FrameType | None) -> None:
    try:
        os.write(2, b"stopped\n")
    finally:  # stderr may be closed
        os._exit(128 + number)


def _as_interrupt(number: int, frame: FrameType | None) -> None:
    """Handle SIGTERM and SIGHUP as Ctrl-C is handled now, or would be where a shell ignores it for a background job."""
    Stop.code = 128 + number
    handler = signal.getsignal(signal.SIGINT)
    interrupts = sys.modules.get("cnnsim.support.interrupts")
    if callable(handler):
        handler(number, frame)
    elif Stop.at_once:
        _end(number, frame)
    elif interrupts is not None and interrupts.Stopping.is_compiling():
        interrupts.Stopping.record()
    else:
        raise KeyboardInterrupt
