"""Workers: processes of this machine or of a Dask cluster that take tasks, and what happens when one of them dies."""

from cnnsim.workers.base import Lost, Workers
from cnnsim.workers.engine import open_workers

__all__ = ["Lost", "Workers", "open_workers"]
