"""Section 3, grids: blocks on worker processes against one process; out of core; memory; sleep; killed workers.

Each figure by itself, at its full size: ``python -m tests.benchmarks.scaling.grids workers --side 16384``,
``sizes --side 1024 --side 32768``, ``sleep --side 16384``, ``kills``.
"""

import argparse
import os
import random
import shutil
import signal
import tempfile
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np

import cnnsim
from cnnsim.network import Template
from cnnsim.supersteps.engine import Engine
from cnnsim.supersteps.pictures import TiledPicture
from tests.benchmarks.accuracy.section import Section
from tests.benchmarks.scaling.peak_memory import command_of, family, peak_memory

WAVE = Template([[0.1, 0.2, 0.1], [0.2, 1.6, 0.2], [0.1, 0.2, 0.1]], 0.4, 0.05, "wave")
STEP = 0.1


class Speckle:
    """Black and white from a hash of row and column: a picture of any size that takes no memory."""

    def __init__(self, side: int) -> None:
        self.shape, self.dtype = (side, side), np.dtype(bool)

    def __getitem__(self, part: Any) -> Any:
        rows, cols = (np.arange(side, dtype=np.uint64)[one] for side, one in zip(self.shape, part[-2:], strict=True))
        mixed = (rows[:, None] // 3 * np.uint64(0x9E3779B97F4A7C15)) ^ (cols // 3 * np.uint64(0xC2B2AE3D27D4EB4F))
        return (mixed * np.uint64(0xD6E8FEB86659FD93)) >> np.uint64(62) > 0


class Rings(Speckle):
    """White with black rings: most of what hole filling starts with stays as it is for long."""

    def __getitem__(self, part: Any) -> Any:
        rows, cols = (np.arange(side)[one] % 512 - 256 for side, one in zip(self.shape, part[-2:], strict=True))
        away = np.hypot(rows[:, None], cols)
        return (away > 150) & (away < 160)


@contextmanager
def folder() -> Iterator[Path]:
    """Give a folder that goes away."""
    made = Path(tempfile.mkdtemp(prefix="scaling-"))
    try:
        yield made / "store"
    finally:
        shutil.rmtree(made)


def made(planes: Any, place: Path) -> tuple[Any, float]:
    """Write a plane that is made in parts as a Zarr array; return it as it is opened, and the seconds it took."""
    import zarr  # slow to import, and only these figures need it

    begun, side = time.perf_counter(), planes.shape[0]
    part = min(side, 1024)
    array = zarr.create_array(place, shape=(side, side), chunks=(part, part), dtype="f4", compressors=None)
    for row in range(0, side, part):
        array[row : row + part] = planes[row : row + part, :]
    return zarr.open_array(place, mode="r"), time.perf_counter() - begun


def warm(workers: int) -> None:
    """Have processes started, and loops compiled in them, before anything is timed: they stay for the next run."""
    small = np.zeros((256, 256), np.float32)
    cnnsim.run_transient(WAVE, **_task(small, 8), engine=Engine(workers=workers, side=64))


def _task(picture: Any, steps: int) -> dict[str, Any]:
    return {"state": picture, "input": picture, "duration": steps * STEP, "step": STEP, "scheme": "euler",
            "dtype": "float32"}  # fmt: skip


def stored(side: int, steps: int, workers: int, **more: Any) -> tuple[float, float, float]:
    """Return the seconds of a run from and to the disk, its peak memory, and the seconds of making its picture."""
    with folder() as store:
        picture, making = made(TiledPicture(Speckle(side), binary=False), store.with_name("picture"))
        warm(workers)
        with peak_memory() as peak:
            begun = time.perf_counter()
            engine = Engine(workers=workers, store=store, **more)
            task = _task(picture, steps) | {"without": ["sleep"]}  # all cells in all steps
            cnnsim.run_transient(WAVE, **task, engine=engine)
            return time.perf_counter() - begun, peak[0], making


def _row(figure: str, side: int, steps: int, seconds: float, ratio: float, memory: float = np.nan) -> dict[str, Any]:
    return {"figure": figure, "side": side, "steps": steps, "seconds": seconds, "peak GiB": memory / 2**30,
            "ns a cell-step": 1e9 * seconds / side**2 / steps, "ratio": ratio}  # fmt: skip


def workers(side: int, steps: int = 256, count: int = 2) -> list[dict[str, Any]]:
    """Compare worker processes, from and to the disk, with one process whose threads share the same cores."""
    picture = TiledPicture(Speckle(side), binary=False)[:, :]
    cnnsim.run_transient(WAVE, **_task(picture[:512, :512], steps))
    begun = time.perf_counter()
    cnnsim.run_transient(WAVE, **_task(picture, steps))
    whole = time.perf_counter() - begun
    del picture
    parts, memory, making = stored(side, steps, count)
    return [
        _row(f"{count} workers against one process", side, steps, parts, whole / parts, memory),
        _row("its picture made and written, in one process", side, 1, making, np.nan),
    ]


def sizes(sides: list[int], steps: int = 256) -> list[dict[str, Any]]:
    """Return the cost of a cell-step over the size of the grid, each against the first."""
    rows: list[dict[str, Any]] = []
    for side in sides:
        seconds, memory, _ = min(stored(side, steps, 2) for _ in range(3 if side < 4096 else 1))
        each = 1e9 * seconds / side**2 / steps
        first = rows[0]["ns a cell-step"] if rows else each
        rows.append(_row("from and to the disk", side, steps, seconds, each / first, memory))
    return rows


def sleep(side: int, time_constants: float = 25.6) -> list[dict[str, Any]]:
    """Compare hole filling with blocks that sleep and without, each with the side that is chosen for it."""
    entry = cnnsim.library.load("hole-filler")
    warm(2)
    with folder() as store:

        def run(cells: int, *without: str, **more: Any) -> float:
            picture, _ = made(TiledPicture(Rings(cells), binary=False), store.with_name("picture"))
            state, _ = made(np.broadcast_to(np.float32(1.0), (cells, cells)), store.with_name("state"))
            begun, place = time.perf_counter(), store.with_name("store")
            cnnsim.run_transient(entry.template, state=state, input=picture, duration=time_constants,
                                 boundary=entry.boundary, dtype="float32", without=without,
                                 engine=Engine(workers=2, store=place, **more))  # fmt: skip
            took = time.perf_counter() - begun
            for one in (place, store.with_name("picture"), store.with_name("state")):
                shutil.rmtree(one)
            return took

        run(512, side=256), run(512, "sleep", side=256)  # these loops too
        asleep, awake = run(side), run(side, "sleep")
    steps = round(time_constants / STEP)
    return [_row("hole filling, without sleep against with it", side, steps, asleep, awake / asleep)]


def kills(runs: int = 10, side: int = 2048, steps: int = 256) -> list[dict[str, Any]]:
    """Kill a worker at a random time in each run; say how many ended with the bytes of the whole grid."""
    given = _task(TiledPicture(Speckle(side), binary=False)[:, :], steps)
    wanted, same, killed = cnnsim.run_transient(WAVE, **given).x.tobytes(), 0, 0

    def run() -> bool:
        return cnnsim.run_transient(WAVE, **given, engine=Engine(workers=2, side=128, depth=8)).x.tobytes() == wanted

    warm(2)
    begun = time.perf_counter()
    run()
    usual, begun = time.perf_counter() - begun, time.perf_counter()
    for number in range(runs):
        over, seed = threading.Event(), random.Random(number)

        def kill(over: threading.Event = over, seed: random.Random = seed) -> None:
            nonlocal killed
            if over.wait(usual * (0.1 + 0.7 * seed.random())):
                return
            if crew := [process for process in family()[1:] if b"popen_loky" in command_of(process)]:
                os.kill(seed.choice(crew), signal.SIGKILL)
                killed += 1

        thread = threading.Thread(target=kill)
        thread.start()
        same += run()
        over.set()
        thread.join()
    figure = f"a worker killed in {killed} of {runs} runs: the share that gave the same bytes"
    return [_row(figure, side, steps, time.perf_counter() - begun, same / runs)]


def section(side: int) -> Section:
    """Measure all figures on grids up to ``side``."""
    rows = [*workers(side), *sizes([1024, *([side] if side > 1024 else [])]), *sleep(side), *kills(2)]
    answer = (
        f"Grids: at {side} x {side} two workers reach {rows[0]['ratio']:.2f} of the rate of one process with both "
        f"cores, from and to the disk; hole filling is {_of(rows, 'hole')['ratio']:.2g} x as fast with "
        "cells that sleep."
    )
    return Section("grids", "3. Grids on the disk", answer, _text(rows), rows, lambda f: _draw(f, rows), (7, 3.6))


def _of(rows: list[dict[str, Any]], start: str) -> dict[str, Any]:
    return next(row for row in rows if row["figure"].startswith(start))


_TEXT = """\
256 Euler steps of nine taps in float32, two workers that are there already, in supersteps over a Zarr store, from a
picture that lies in one; no block sleeps but in hole filling. *ratio* is what the line's name says; of the sizes it is
the cost of a cell-step against the smallest. Memory is that of all processes together. A run without an engine takes
20 bytes a cell: 5.4 GB for 16384 x 16384, and is refused with the engine as the cure where that is not free.

| figure | side | seconds | ns a cell-step | peak GiB | ratio |
|---|---|---|---|---|---|
{table}"""


def _text(rows: list[dict[str, Any]]) -> str:
    lines = [
        f"| {row['figure']} | {row['side']} | {row['seconds']:.3g} | {row['ns a cell-step']:.3g} | "
        f"{row['peak GiB']:.2g} | {row['ratio']:.3g} |".replace("nan", "-")
        for row in rows
    ]
    return _TEXT.format(table="\n".join(lines))


def _draw(figure: Any, rows: list[dict[str, Any]]) -> None:
    axes = figure.subplots()
    several = [row for row in rows if row["figure"] == "from and to the disk"]
    axes.semilogx([row["side"] for row in several], [row["ns a cell-step"] for row in several], "o-")
    axes.set(xlabel="cells a side", ylabel="ns a cell-step", ylim=(0, None), title="from and to the disk, two workers")
    axes.grid(alpha=0.3, which="both")


def main() -> None:
    """Measure one figure and print it."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("figure", choices=["workers", "sizes", "sleep", "kills"])
    parser.add_argument("--side", type=int, action="append", default=[])
    given = parser.parse_args()
    sides = given.side or [4096]
    ways: dict[str, Callable[[], list[dict[str, Any]]]] = {
        "workers": lambda: workers(sides[0]), "sizes": lambda: sizes(sides), "sleep": lambda: sleep(sides[0]),
        "kills": kills,
    }  # fmt: skip
    for row in ways[given.figure]():
        print(row)


if __name__ == "__main__":
    main()
