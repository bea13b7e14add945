"""The option `--threads`: how many threads of the CPU backend share a grid, measured where it is not said."""

from typing import Any

import click

from cnnsim import backends
from cnnsim.backends.base import Backend

SMALL = 2048
"""Cells of a grid that one thread computes anyway, whatever the template (at most nine taps of a common one)."""

threads_option = click.option(
    "--threads", type=click.IntRange(1),
    help="Threads of the cpu backend on large grids; without it as many as are fastest now: one on a busy machine.",
)  # fmt: skip


def find_backend(
    name: str, dtype: Any = None, device: str | None = None, threads: int | None = None, cells: int | None = None
) -> Backend:
    """Return a backend as `backends.get`, on as many threads as pay on a grid of ``cells`` if none are given.

    Raises:
        InputError: as `backends.get`.
    """
    if name == "cpu" and threads is None and (cells is None or cells > SMALL):
        from cnnsim.backends.cpu.threads import threads_that_pay  # numba is slow to import

        threads = threads_that_pay()
    return backends.get(name, dtype, device, threads)
