"""Readers run on broken files: which files were read, which refused in one line, and which taken badly.

python -m tests.fuzz.taken 3400 pictures          one part of `broken_files.PARTS`; three times as many files a kind
"""

import json
import os
import sys
import tempfile
import traceback
import warnings
from collections.abc import Callable
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import Any

from cnnsim.support import InputError
from tests.fuzz.broken_files import PARTS
from tests.fuzz.guarded import Guard, Verdict
from tests.fuzz.readers import BY_NAME, BY_SUFFIX, read_source

OWN = 4
"""Bags that are read as the product does it, in a process of their own for each."""


def judge(path: Path) -> Verdict:
    """Return what is wrong with how a file was taken."""
    return _judged(path, (BY_NAME[path.name],) if path.name in BY_NAME else BY_SUFFIX[path.suffix])


def _judged(path: Path, readers: tuple[Callable[[Path], None], ...]) -> Verdict:
    told = Verdict()
    for reader in readers:
        try:
            reader(path)
            told.read = True
        except InputError as error:
            if not str(error):
                told.faults.append("an error that says nothing")
        except MemoryError:
            told.faults.append("no memory: " + traceback.format_exc().splitlines()[-3].strip())
        except Exception as error:
            last = traceback.extract_tb(error.__traceback__)[-1]
            told.faults.append(f"{type(error).__name__}: {str(error)[:100]} at {last.filename}:{last.lineno}")
    return told


@dataclass
class Taken:
    """How the files of a kind were taken: how many, how many of them read, processor time [s], and the bad ones."""

    files: int = 0
    read: int = 0
    seconds: float = 0.0
    bad: list[str] = field(default_factory=list)


def take(part: str, count: int) -> dict[str, Taken]:
    """Judge the files of a part, and return by name how they were taken."""
    warnings.simplefilter("ignore")
    os.environ["CNNSIM_MEMORY"] = "500M"  # pictures may be as large as the memory that is free
    taken: dict[str, Taken] = {}
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        if part == "bags":  # within a gigabyte there is no place for other libraries
            from rosbags import highlevel, typesys

            del highlevel
            typesys.get_typestore(typesys.Stores.ROS2_HUMBLE)
        guard, own = Guard(judge), Guard(lambda path: _judged(path, (read_source,)))
        for file, data in PARTS[part](folder, count):
            one = taken.setdefault(file, Taken())
            if one.files == 0 and part != "bags":  # what a reader loads counts for none of the files
                (folder / file).write_bytes(b"x")
                judge(folder / file)
            (folder / file).write_bytes(data)
            told = (own if file.endswith(".bag") and one.files < OWN else guard).judge(folder / file)
            one.files += 1
            one.read += told.read
            one.seconds += told.seconds
            one.bad += [f"{file} ({len(data)} bytes, begins {data[:60]!r}): {fault}" for fault in told.faults]
        guard.close()
        own.close()
    return taken


def main(count: int, parts: list[str]) -> dict[str, Any]:
    """Judge the files of parts, all but that of the bags in one process."""
    found: dict[str, Any] = {}
    for part in parts:
        found |= {name: asdict(one) for name, one in take(part, count).items()}
    return found


if __name__ == "__main__":
    print(json.dumps(main(int(sys.argv[1]), sys.argv[2:] or list(PARTS))))
