"""Response tables of bumps, and their cache on disk."""

import contextlib
import hashlib
import os
import tempfile
from collections.abc import Callable
from dataclasses import dataclass, fields
from pathlib import Path

import numpy as np

from cnnsim.support import Floats, InputError
from cnnsim.support.array_files import read_npz_arrays
from cnnsim.support.cache_folder import user_cache

VERSION = 2
"""Version of the numbers: tables of another version are computed again."""


@dataclass(frozen=True)
class Response:
    """Readings at one depth around a bump, see ``bump.response``.

    ``radii`` (n,) [m]; ``forces`` (k,) [N] of the table, one newton where it is linear; ``indentations`` (k,) [m] at
    these forces, NaN where linear; ``normal`` (k, n, 2): zz and rz under these forces; ``shear`` (k, n, 3): zz, even
    and odd per newton of shear; ``stiffness`` (2,): force over displacement of the plate [N/m], along z, then x.
    """

    radii: Floats
    forces: Floats
    indentations: Floats
    normal: Floats
    shear: Floats
    stiffness: Floats

    @property
    def linear(self) -> bool:
        """Whether the response is linear in the force."""
        return len(self.forces) == 1


def folder() -> Path:
    """Return the folder of tables in the user's cache."""
    return user_cache() / "cellular-wave-touch" / "bumps"


def remembered(key: str, make: Callable[[], Response]) -> Response:
    """Return the table of a ``key`` from the cache, or from ``make``, and write it there.

    A file that cannot be read, or has another key, is made again. A cache that cannot be written is not used.
    """
    key = f"{VERSION} {key}"
    path = folder() / f"{hashlib.sha256(key.encode()).hexdigest()[:24]}.npz"
    names = ["key", *(part.name for part in fields(Response))]
    with contextlib.suppress(InputError, KeyError):
        kept = read_npz_arrays(path, "table of a bump", names)
        if str(kept.pop("key")) == key:
            return Response(**{name: kept[name] for name in names[1:]})
    table = make()
    with contextlib.suppress(OSError):
        _keep(path, key, table)
    return table


def _keep(path: Path, key: str, table: Response) -> None:
    path.parent.mkdir(parents=True, exist_ok=True)
    handle, name = tempfile.mkstemp(dir=path.parent, suffix=".part")
    try:
        with os.fdopen(handle, "wb") as file:
            np.savez(file, key=key, **vars(table))
        Path(name).replace(path)  # readers see a whole file or none
    except BaseException:
        Path(name).unlink(missing_ok=True)
        raise
