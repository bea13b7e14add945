"""Section 1, rates: time of a frame in simulator, inverse, localisation and event programs; bytes on the wire."""

from collections.abc import Callable
from statistics import median
from time import perf_counter
from typing import Any

import numpy as np

from cnnsim.support.command_line import watched
from tactile.finger import Finger
from tactile.inverse.localise import localise
from tactile.settings import Settings
from tactile.simulator.contacts.moving_load import MovingLoad
from tactile.simulator.scene.scene import Scene
from tests.benchmarks.accuracy.section import Section
from tests.benchmarks.scaling.taxels import MODULUS, array_of, frame_of, random_loads

SIDES = (2, 8, 32, 128, 512, 1024)
PATIENCE = 1.0
"""Seconds for the timing of one stage; its median counts."""
STAGES = ("simulator", "inverse", "all taxels", "events", "frame")
LINKS = (0.0921, "UART 921 600 baud"), (1.2, "USB full speed"), (40, "USB high speed"), (110, "gigabit Ethernet")
"""What links carry [MB/s]."""
HEADER, CRC, FRAMING = 17, 2, 2
"""Bytes of the native format: header, check, and the first and last byte of COBS, which adds one more in 254."""


def wire_bytes(side: int) -> int:
    """Return the bytes of a frame of int16 values in the native format; sizes beyond its header as if it had them."""
    body = HEADER + 2 * 3 * side * side + CRC
    return body + FRAMING + body // 254


def timed(call: Callable[[], Any], least: int = 3) -> float:
    """Return the median time of a call [s], after one that does not count."""
    call()
    times: list[float] = []
    until = perf_counter() + PATIENCE
    while len(times) < least or (perf_counter() < until and len(times) < 1000):
        begun = perf_counter()
        call()
        times.append(perf_counter() - begun)
        if sum(times) > 10 * PATIENCE:
            break
    return median(times)


def measured(side: int) -> dict[str, Any]:
    """Return the times [s] of the stages of one frame, and its bytes."""
    array, random = array_of(side), np.random.default_rng(side)
    finger = Finger(array, MODULUS, Settings())
    raws = [frame_of(array, random_loads(array, 1, 0.0, random), 0.003, random) for _ in range(2)]
    raw = raws[0]
    frame = finger.calibrate(raw)
    inverse, machine = finger._inverse, finger._machine
    assert inverse is not None
    signals = {name: frame.values[..., i] for i, name in enumerate(inverse.inputs)}
    load, count = finger.locate(frame), [0]

    def notice() -> None:
        count[0] += 1
        finger.detect(finger.calibrate(raws[count[0] % 2]), load)

    def whole() -> None:
        count[0] += 1
        one = finger.calibrate(raws[count[0] % 2])
        finger.detect(one, finger.locate(one))

    row: dict[str, Any] = {"taxels a side": side, "taxels": side * side}
    row["simulator"] = _simulated(side)
    row["inverse"] = timed(lambda: machine.run(inverse, **signals))
    planes = tuple(machine.run(inverse, **signals).values())
    row["all taxels"] = timed(lambda: localise(array.positions(), planes[:4], planes[4:], array.depth))
    row["events"] = timed(notice)
    row["frame"] = timed(whole)
    return row | {"bytes": wire_bytes(side), "MB/s at 1 kHz": wire_bytes(side) / 1000}


def _simulated(side: int) -> float:
    frames = max(2, min(1000, int(4e6 / side**2)))
    path = np.array([(0.0, 0, 0, 0, 0, 0.5), (10.0, 1e-3, 1e-3, 0.1, 0, 0.5)])
    scene = Scene("press", 1000.0, frames / 1000, MODULUS, (array_of(side),), (MovingLoad(0, path),))
    return timed(lambda: [None for _ in scene.batches(0)]) / frames


def section(sides: tuple[int, ...] = SIDES) -> Section:
    """Measure all sizes."""
    rows = [measured(side) for side in watched(sides, "rates", len(sides))]
    of = {row["taxels a side"]: row for row in rows}
    answer = "Times of the sizes that were measured are below."
    if 8 in of and 32 in of:
        kept = "one core keeps up with 1 kHz" if of[32]["frame"] < 1e-3 else f"up to {1 / of[32]['frame']:.0f} Hz"
        answer = (
            f"An array of 8 x 8 taxels at 1 kHz sends {of[8]['MB/s at 1 kHz']:.2f} MB/s, which USB carries and a UART "
            f"at 921 600 baud does not. A frame takes {1e6 * of[8]['frame']:.0f} us of one core. "
            f"At 32 x 32 taxels it is {of[32]['MB/s at 1 kHz']:.1f} MB/s and {1e6 * of[32]['frame']:.0f} us: {kept}."
        )
    return Section(
        "rates", "Time and bytes of a frame", answer, _text(rows), rows, lambda f: _draw(f, rows), (11, 4.2), _SEE
    )


_SEE = (
    "Left: up to 32 x 32 taxels each stage is faster than the dashed line, 1 kHz. "
    "Beyond 1000 taxels the rates fall as taxels are added. "
    "Right: the bytes of a frame are proportional to the taxels; the lines are what links carry."
)
_TEXT = """\
A frame under one load with 0.3 % noise, {pitch} mm pitch and depth, median times on this machine ({note}). *simulator*:
a frame of the half-space; *inverse*: the load of each taxel; *all taxels*: the consensus of all taxels and a least
squares fit, on pads above 16 x 16 of several loads; *events*: tare, comparators and detectors; *frame*: tare, inverse,
localisation and events, the latency from the last byte to the event.

| taxels | {stages} | bytes | MB/s at 1 kHz |
|---|{rule}---|---|
{table}"""


def _text(rows: list[dict[str, Any]]) -> str:
    lines = []
    for row in rows:
        times = " | ".join(_time(row[stage]) for stage in STAGES)
        lines.append(f"| {row['taxels a side']} x {row['taxels a side']} | {times} | {row['bytes']} | "
                     f"{row['MB/s at 1 kHz']:.3g} |")  # fmt: skip
    return _TEXT.format(
        pitch=1.5, note="one frame at a time, on the cpu backend", stages=" | ".join(STAGES), rule="---|" * len(STAGES),
        table="\n".join(lines),
    )  # fmt: skip


def _time(seconds: float) -> str:
    if seconds < 1:
        return f"{1e6 * seconds:.3g} us" if seconds < 1e-3 else f"{1e3 * seconds:.3g} ms"
    return f"{seconds:.3g} s"


def _draw(figure: Any, rows: list[dict[str, Any]]) -> None:
    left, right = figure.subplots(1, 2)
    for stage in STAGES:
        rates = [1 / row[stage] for row in rows]
        left.loglog([row["taxels"] for row in rows], rates, "o-", label=stage, markersize=4)
    left.set(title="Frames a second", xlabel="taxels", ylabel="1/s")
    left.axhline(1000, color="0.5", lw=0.8, ls="--")
    right.loglog([row["taxels"] for row in rows], [row["MB/s at 1 kHz"] for row in rows], "o-", markersize=4)
    for rate, _ in LINKS:
        right.axhline(rate, color="0.5", lw=0.8, ls="--")
    links = right.secondary_yaxis("right")
    links.set_yticks([rate for rate, _ in LINKS], [name for _, name in LINKS])
    right.set(title="Wire at 1 kHz", xlabel="taxels", ylabel="MB/s")
    figure.legend(*left.get_legend_handles_labels(), fontsize=9, ncols=len(STAGES), loc="outside upper left")
    for axes in (left, right):
        axes.grid(alpha=0.3)
