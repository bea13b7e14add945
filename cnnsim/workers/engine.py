"""Workers by the name of their engine: "processes" of this machine, "dask" on it, or "dask=ADDRESS" of a scheduler."""

from collections.abc import Iterator
from contextlib import contextmanager

from cnnsim.support import InputError
from cnnsim.workers.base import Workers, cores


def check_engine_name(name: str) -> None:
    """Refuse what is no engine.

    Raises:
        InputError: it is another word, or an address is empty.
    """
    if name not in ("processes", "dask") and (name == "dask=" or not name.startswith("dask=")):
        raise InputError(f"engine {name!r}; processes, dask or dask=ADDRESS wanted")


@contextmanager
def open_workers(name: str, count: int | None = None) -> Iterator[Workers]:
    """Give workers by their name, see above; ``count`` of them, None for one a core, or for all that a cluster has.

    Raises:
        InputError: an unknown name, a library that is missing, a scheduler that does not answer.
    """
    check_engine_name(name)
    if count is not None and count < 1:
        raise InputError(f"{count} workers; 1 or more wanted")
    if name == "processes":
        from cnnsim.workers.local import LocalWorkers  # joblib is slow to import

        yield LocalWorkers(count or cores())
    else:
        from cnnsim.workers.cluster import cluster_workers  # so is dask

        with cluster_workers(name.removeprefix("dask").removeprefix("="), count) as workers:
            yield workers
