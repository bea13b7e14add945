"""Every reader of a file run on one file: what it raises, how long it takes, how much memory the process has had."""

import json
import os
import resource
import subprocess
import sys
import tempfile
import time
import traceback
import warnings
from collections.abc import Callable
from itertools import islice
from pathlib import Path
from typing import Any

from cnnsim.support import InputError
from tests.fuzz.broken_files import all_files

SLOW = 5.0
"""[s] of the processor that no file may take."""
LARGE = 1000 * 2**20
"""Bytes that no file may take beyond what the readers themselves need."""
LIMIT = 3000 * 2**20
"""Bytes beyond which the system gives none: what is asked for in vain is no harm, but a fault where it is not told."""
OWN = 4
"""Bags that are read as the product does it, in a process of their own."""
FRAMES = 1000
"""Frames that are read of a recording: a scene of a year is no broken file."""


def _source(path: Path) -> None:
    from tactile.sources import open_source

    for _ in islice(open_source(path), FRAMES):
        pass


def _template(path: Path) -> None:
    from cnnsim.library.read import load_file

    load_file(path)


def _program(path: Path) -> None:
    from cnnsim.program.file import load_program

    load_program(path)


def _array(path: Path) -> None:
    from tactile.wire.description_file import read_description

    read_description(path)


def _calibration(path: Path) -> None:
    from tactile.calibration.file import load_calibration

    load_calibration(path)


def _truth(path: Path) -> None:
    from cnnsim.prototyping.design.rule_files import read_table

    read_table(path)


def _foreign(path: Path) -> None:
    from cnnsim.formats.files import import_file

    with tempfile.TemporaryDirectory() as folder:
        import_file(path, Path(folder), replace=True)


def _picture(path: Path) -> None:
    from cnnsim.support.pictures.read import read_pictures

    read_pictures(path)


BY_NAME: dict[str, Callable[[Path], None]] = {
    "template.toml": _template, "program.toml": _program, "array.toml": _array, "calibration.toml": _calibration,
    "truth.toml": _truth,
}  # fmt: skip
BY_SUFFIX: dict[str, tuple[Callable[[Path], None], ...]] = {
    ".toml": (_source,), ".csv": (_source,), ".npz": (_source, _picture), ".npy": (_picture,), ".parquet": (_source,),
    ".mcap": (_source,), ".bag": (_source,), ".m": (_foreign,), ".gene": (_foreign,), ".json": (_foreign,),
    ".cnnsim": (_foreign,), ".tem": (_foreign,), ".png": (_picture,), ".gif": (_picture,), ".bmp": (_picture,),
    ".tif": (_picture,), ".jpg": (_picture,), ".pgm": (_picture,),
}  # fmt: skip


def judge(path: Path) -> list[str]:
    """Return what is wrong with how a file was taken, in words."""
    found = []
    readers = (BY_NAME[path.name],) if path.name in BY_NAME else BY_SUFFIX[path.suffix]
    for reader in readers:
        begun = time.process_time()  # a busy machine is not the file's fault
        try:
            reader(path)
        except InputError as error:
            if not str(error):
                found.append("an error that says nothing")
        except MemoryError:
            found.append("no memory: " + traceback.format_exc().splitlines()[-3].strip())
        except Exception as error:
            last = traceback.extract_tb(error.__traceback__)[-1]
            found.append(f"{type(error).__name__}: {str(error)[:100]} at {last.filename}:{last.lineno}")
        seconds = time.process_time() - begun
        if seconds > SLOW:
            found.append(f"{seconds:.1f} s")
    return found


class Bags:
    """Bags after the first few: judged by `bag_children`."""

    def __init__(self) -> None:
        self._process = subprocess.Popen(
            [sys.executable, "-m", "tests.fuzz.bag_children"], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True,
            env={**os.environ, "OPENBLAS_NUM_THREADS": "1"},
        )  # fmt: skip

    def judge(self, path: Path) -> list[str]:
        """Return what is wrong with how a bag was taken, in words."""
        assert self._process.stdin is not None
        assert self._process.stdout is not None
        self._process.stdin.write(f"{path}\n")
        self._process.stdin.flush()
        code, seconds, *said = self._process.stdout.readline().split(" ", 2)
        found = [f"{seconds} s"] if float(seconds) > SLOW else []
        if int(code) not in (0, 2) or (code == "2" and not "".join(said).strip()):
            found.append(f"ended with {code}: {said}")
        return found

    def close(self) -> None:
        """Let it end."""
        self._process.communicate()


def peak() -> int:
    """Return the most memory that this process has had [bytes]."""
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * 1024


def main(count: int, part: int = 0, parts: int = 1, watch: bool = False) -> dict[str, Any]:
    """Run every ``parts``-th file from ``part`` on, keep those that were taken badly."""
    warnings.simplefilter("ignore")
    os.environ["CNNSIM_MEMORY"] = "500M"  # pictures may be as large as the memory that is free
    bad: list[str] = []
    seen: dict[str, int] = {}
    took: dict[str, float] = {}
    bags = Bags()
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        for warm in BY_SUFFIX:  # what the readers load counts for none of the files
            (folder / f"warm{warm}").write_bytes(b"x")
            judge(folder / f"warm{warm}")
        used = int(Path("/proc/self/statm").read_text().split()[0]) * resource.getpagesize()
        resource.setrlimit(resource.RLIMIT_AS, (used + LIMIT, used + LIMIT))
        for file, data in islice(all_files(folder, count), part, None, parts):
            path = folder / file
            path.write_bytes(data)
            if watch:
                print(file, len(data), data[:40], f"{peak() / 1e6:.0f} MB", file=sys.stderr, flush=True)
            before = peak()
            started = time.process_time()
            faults = judge(path) if path.suffix != ".bag" or seen.get(".bag", 0) < OWN else bags.judge(path)
            took[path.suffix] = took.get(path.suffix, 0.0) + time.process_time() - started
            if peak() - before > LARGE:
                faults.append(f"{(peak() - before) / 1e6:.0f} MB")
            bad += [f"{file} ({len(data)} bytes, begins {data[:60]!r}): {fault}" for fault in faults]
            seen[path.suffix] = seen.get(path.suffix, 0) + 1
    bags.close()
    return {"seen": seen, "bad": bad, "took": took}


if __name__ == "__main__":
    numbers = [int(word) for word in sys.argv[1:] if word.isdigit()]
    count, part, parts = numbers if len(numbers) > 1 else (numbers[0], 0, 1)
    print(json.dumps(main(count, part, parts, "watch" in sys.argv)))
