"""PoCL's cache of kernels: a folder of this user alone, and damaged entries dropped before PoCL can end the process.

PoCL reads what it finds; a file that is cut short ends the process (SIGABRT). So at the end of each process a list of
all files with their sizes and times is kept beside them, and at the start of the next one whatever is not as it was is
deleted, and made anew when it is wanted. Where the last process ended hard, what is not in the list goes as well. Of
more than `MOST` files, which take too long to look at, there is no list: then after a hard end all go.
"""

import atexit
import json
import os
import shutil
import tempfile
from collections.abc import Iterator
from contextlib import suppress
from functools import cache
from itertools import islice
from pathlib import Path

from cnnsim.support.cache_folder import first_usable, user_cache

VARIABLE = "POCL_CACHE_DIR"
LIST = "cnnsim-files.json"
_BUSY = "cnnsim-busy-"
_CODE = (".bc", ".so")

MOST = 1000
"""Files that are looked at: some ten milliseconds."""

Files = dict[str, list[int]]
"""Of each file, by its path in the folder, size and time of the last change [ns]."""


@cache
def prepare() -> Path:
    """Choose the folder, drop what is damaged, and tell PoCL by its environment variable; once, before it is loaded."""
    asked = os.environ.get(VARIABLE)
    usual = Path(asked) if asked else user_cache() / "pocl" / "kcache"
    folder = first_usable([usual, user_cache() / "cellular-wave-touch" / "pocl"], "OpenCL kernels")
    os.environ[VARIABLE] = str(folder)
    drop_damaged(folder)
    with suppress(OSError):
        busy = folder / f"{_BUSY}{os.getpid()}"
        busy.touch()
        atexit.register(_leave, folder, busy)
    return folder


def drop_damaged(folder: Path) -> None:
    """Delete the programs of which a file is not as the list says; all unknown ones after a process that ended hard."""
    try:
        known: Files = json.loads((folder / LIST).read_text(encoding="utf-8"))
        assert all(isinstance(of, list) for of in known.values())
    except (OSError, ValueError, AttributeError, AssertionError):
        known = {}
    others = {path: _alive(path.name.removeprefix(_BUSY)) for path in folder.glob(f"{_BUSY}*")}
    ended_hard = bool(others) and not any(others.values())
    there = dict(_files(folder)) if known or ended_hard else {}
    damaged = {path for path, of in known.items() if there.get(path) != of}
    if ended_hard:
        damaged |= there.keys() - known.keys()
    for path in damaged:
        shutil.rmtree(folder.joinpath(*Path(path).parts[:2]), ignore_errors=True)
    for busy, alive in others.items():
        if not alive:
            busy.unlink(missing_ok=True)


def _leave(folder: Path, busy: Path) -> None:
    with suppress(OSError):
        handle, name = tempfile.mkstemp(dir=folder)
        with os.fdopen(handle, "w", encoding="utf-8") as file:
            some = dict(islice(_files(folder), MOST + 1))
            json.dump(some if len(some) <= MOST else {}, file)
        Path(name).replace(folder / LIST)
        busy.unlink(missing_ok=True)


def _files(folder: Path) -> Iterator[tuple[str, list[int]]]:
    for parent, _, names in os.walk(folder):
        for name in names:
            if name.endswith(_CODE) and parent != str(folder):
                path = Path(parent, name)
                with suppress(OSError):  # deleted by another process
                    found = path.stat()
                    yield str(path.relative_to(folder)), [found.st_size, found.st_mtime_ns]


def _alive(pid: str) -> bool:
    try:
        os.kill(int(pid), 0)
    except (ValueError, ProcessLookupError):
        return False
    except OSError:
        return True
    return True
