"""Section 2, grids: supersteps on worker processes from and to the disk against one process in memory."""

import shutil
import tempfile
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np

import cnnsim
from cnnsim.network import Template
from cnnsim.supersteps.engine import Engine
from tests.benchmarks.accuracy.section import Section

WAVE = Template([[0.1, 0.2, 0.1], [0.2, 1.6, 0.2], [0.1, 0.2, 0.1]], 0.4, 0.05, "wave")
STEP, STEPS, WORKERS = 0.1, 256, 2


@contextmanager
def stored(planes: dict[str, Any]) -> Iterator[tuple[dict[str, Any], Path]]:
    """Give planes as Zarr arrays, and the folder of a store."""
    import zarr  # slow to import

    folder = Path(tempfile.mkdtemp(prefix="scaling-"))
    try:
        for name, plane in planes.items():
            zarr.create_array(folder / name, data=plane.astype("f4"), chunks=(1024, 1024), compressors=None)
        yield {name: zarr.open_array(folder / name, mode="r") for name in planes}, folder / "store"
    finally:
        shutil.rmtree(folder)


def speckle(side: int) -> Any:
    """Return a black and white picture of random squares."""
    small = np.random.default_rng(1).random((-(-side // 3), -(-side // 3))) < 0.25
    return np.where(small.repeat(3, 0).repeat(3, 1)[:side, :side], 1.0, -1.0)


def rings(side: int) -> Any:
    """Return black rings on white: hole filling leaves most cells at rest after a while."""
    at = np.arange(side) % 512 - 256
    away = np.hypot(at[:, None], at)
    return np.where((away > 150) & (away < 160), 1.0, -1.0)


def seconds(template: Any, planes: dict[str, Any], **choices: Any) -> float:
    """Return the seconds of a run on two workers that are started already."""
    with stored(planes) as (given, store):
        begun = time.perf_counter()
        cnnsim.run_transient(template, **given, **choices, dtype="float32", engine=Engine(workers=WORKERS, store=store))
        return time.perf_counter() - begun


def _row(figure: str, side: int, taken: float, ratio: float) -> dict[str, Any]:
    return {"figure": figure, "side": side, "seconds": taken, "ns a cell-step": 1e9 * taken / side**2 / STEPS,
            "ratio": ratio}  # fmt: skip


def section(side: int) -> Section:
    """Measure grids up to ``side``."""
    euler: dict[str, Any] = {"duration": STEPS * STEP, "step": STEP, "scheme": "euler"}
    filler = cnnsim.library.load("hole-filler")
    filling: dict[str, Any] = {"duration": 2 * STEPS * STEP, "boundary": filler.boundary}
    for template, choices in ((WAVE, euler), (filler.template, filling)):  # start workers, compile loops
        seconds(template, {"state": speckle(256), "input": speckle(256)}, **choices)
    picture = speckle(side)
    begun = time.perf_counter()
    cnnsim.run_transient(WAVE, state=picture.astype("f4"), input=picture.astype("f4"), dtype="float32", **euler)
    whole = time.perf_counter() - begun
    parts, small = (
        seconds(WAVE, {"state": plane, "input": plane}, **euler)
        for plane in (picture, picture[: side // 4, : side // 4])
    )
    holes = {"state": np.ones((side, side)), "input": rings(side)}
    filled = seconds(filler.template, holes, **filling)
    rows = [
        _row("2 workers against one process in memory", side, parts, whole / parts),
        _row("a grid of a sixteenth of the cells", side // 4, small, 16 * small / parts),
        _row("hole filling against a wave of as many steps", side, filled / 2, 2 * parts / filled),
    ]
    answer = (
        f"At {side} x {side} cells two workers that read and write the disk reach {whole / parts:.2f} of the rate "
        "of one process in memory."
    )
    return Section("grids", "Grids on the disk", answer, _text(rows), rows, lambda f: _draw(f, rows), (8, 2.6), _SEE)


_SEE = "The cost of a cell-step falls with the size, because reading and writing take a smaller share."
_TEXT = """\
256 Euler steps of nine taps in float32 (hole filling: 512) on two workers that are started already, in supersteps over
a Zarr store, from a picture in a Zarr array. *ratio*: what the line's name says; of the smaller grid, its cost of a
cell-step against the larger one. A run without an engine takes 20 bytes a cell: 5.4 GB for 16384 x 16384; if that is
not free, it is refused, and the message names the engine.

| figure | side | seconds | ns a cell-step | ratio |
|---|---|---|---|---|
{table}"""


def _text(rows: list[dict[str, Any]]) -> str:
    lines = [
        f"| {row['figure']} | {row['side']} | {row['seconds']:.3g} | {row['ns a cell-step']:.3g} | {row['ratio']:.3g} |"
        for row in rows
    ]
    return _TEXT.format(table="\n".join(lines))


def _draw(figure: Any, rows: list[dict[str, Any]]) -> None:
    axes = figure.subplots()
    axes.barh([row["figure"] for row in rows], [row["ns a cell-step"] for row in rows])
    axes.set(xlabel="ns a cell-step", title="two workers, from and to the disk")
