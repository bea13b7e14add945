"""Section 4, on paper: grids of 10^6 x 10^6 cells, and thousands of arrays at 1 kHz, from the measured figures."""

from collections.abc import Mapping
from typing import Any

from cnnsim.supersteps.engine import LARGEST
from tests.benchmarks.accuracy.section import Section
from tests.benchmarks.scaling.rates import wire_bytes

SIDE, BLOCK, DEPTH, STEPS = 10**6, 8192, 64, 256
ARRAYS, ARRAY, RATE = 4096, 8, 1000.0
PLANE, PLANES = 4, 3
"""Bytes of a number; planes on the disk: two states and the input."""
DISK, NETWORK = 2e9, 1.25e9
"""What a node's disk and its link carry [bytes/s]: a fast NVMe disk, and 10 Gbit/s."""
CORES = 64
"""Of a node."""
TASK = 2e-3
"""Seconds of the scheduler for a task: Dask's own documentation says 1 ms or less; twice that is reckoned with."""


def section(cell_step: float, frame: float) -> Section:
    """Reckon from the seconds of a cell-step on one core and of a frame of 8 x 8 taxels."""
    rows = [*grid(cell_step), *arrays(frame)]
    of: Mapping[str, float] = {row["what"]: row["value"] for row in rows}
    answer = (
        f"On paper (calculation, not measured): 256 steps of 10^6 x 10^6 cells take {of['core hours']:.3g} core hours "
        f"and {of['store, TB']:.0f} TB of disk; the disks are the first to be full, the scheduler is not. {ARRAYS} "
        f"arrays of 8 x 8 at 1 kHz take {of['cores for the frames']:.0f} cores and "
        f"{of['wire, MB/s']:.0f} MB/s; what breaks first is one process for all of them."
    )
    return Section(
        "paper", "4. Plans on paper (calculation)", answer, _text(rows), rows, lambda f: _draw(f, rows), (7, 3.4)
    )


def grid(cell_step: float) -> list[dict[str, Any]]:
    """Reckon the largest grid."""
    cells, blocks = float(SIDE) ** 2, (-(-SIDE // BLOCK)) ** 2
    halo = (1 + 2 * DEPTH / BLOCK) ** 2
    supersteps = STEPS // DEPTH
    work = cells * STEPS * halo * cell_step
    traffic = cells * PLANE * (2 * halo + 1) * supersteps
    nodes = 100
    computed = f"{cells:.0e} cells x {STEPS} steps x halo {halo:.3f} x {1e9 * cell_step:.3g} ns"
    carried = f"{traffic / 1e15:.3g} PB at {DISK / 1e9:g} GB/s each"
    return [
        _row("core hours", work / 3600, computed),
        _row("store, TB", cells * PLANE * PLANES / 1e12, f"{PLANES} planes of {PLANE} bytes"),
        _row("blocks", blocks, f"of {BLOCK} x {BLOCK} (`--block`): fewer tasks than of those chosen, {LARGEST}"),
        _row("scheduler, s a superstep", blocks * TASK, f"{TASK * 1e3:g} ms a task, in one thread"),
        _row("hours of 100 nodes computing", work / 3600 / CORES / nodes, f"{CORES} cores each"),
        _row("hours of 100 nodes' disks", traffic / 3600 / DISK / nodes, carried),
        _row("hours over one shared link", traffic / 3600 / NETWORK, f"at {NETWORK / 1e9:g} GB/s: spread it"),
    ]  # fmt: skip


def arrays(frame: float) -> list[dict[str, Any]]:
    """Reckon many arrays at once."""
    each = wire_bytes(ARRAY)
    return [
        _row("cores for the frames", ARRAYS * RATE * frame, f"{ARRAYS} arrays x {RATE:g} Hz x {1e6 * frame:.0f} us"),
        _row("wire, MB/s", ARRAYS * RATE * each / 1e6, f"{each} bytes a frame"),
        _row("packets a second", ARRAYS * RATE, "a frame each; bundled by 16 a link, a sixteenth of that"),
        _row("recording, TB a day", ARRAYS * RATE * each * 86400 / 1e12, "as it comes"),
    ]


def _row(what: str, value: float, reckoned: str) -> dict[str, Any]:
    return {"what": what, "value": value, "from": reckoned}


_TEXT = """\
**Nothing here was measured at these sizes**: it is multiplied out from the figures above, on cores as fast as this
machine's.

| what | value | from |
|---|---|---|
{table}

What breaks first. Of the grid: the disks, in size and then in rate; a block's halo crosses the network once a superstep
only if blocks stay with the workers that have them, so each node wants its own part of the store. The record of a
superstep is one JSON text of all blocks (a few MB here), and the scheduler hands out a superstep's tasks in
{tasks:.0f} s, in which 100 nodes of 64 cores compute {share:.0f} blocks each: both still small. Of the arrays: Python's
one process, at {one:.0f} arrays a core; then the number of packets, before their bytes."""


def _text(rows: list[dict[str, Any]]) -> str:
    of = {row["what"]: row["value"] for row in rows}
    lines = [f"| {row['what']} | {row['value']:.3g} | {row['from']} |" for row in rows]
    return _TEXT.format(
        table="\n".join(lines), tasks=of["scheduler, s a superstep"], share=of["blocks"] / 100,
        one=ARRAYS / max(of["cores for the frames"], 1e-9),
    )  # fmt: skip


def _draw(figure: Any, rows: list[dict[str, Any]]) -> None:
    hours = [row for row in rows if "hours of" in row["what"] or "hours over" in row["what"]]
    axes = figure.subplots()
    axes.barh([row["what"] for row in hours], [row["value"] for row in hours])
    axes.set(xscale="log", xlabel="hours", title="10^6 x 10^6 cells, 256 steps (calculation)")
