"""Section 6, touch: time of a frame against what is asked of the pipeline: code, loads, textures, users' programs."""

from collections.abc import Callable
from time import perf_counter
from typing import Any

import numpy as np

from cnnsim.support.command_line import watched
from tactile import pipeline
from tactile.core.frame import Frame, TaxelArray
from tactile.core.source import FrameStream
from tactile.finger import Finger
from tactile.inverse.load import Load
from tactile.inverse.validity import Validity
from tactile.settings import Settings
from tactile.simulator.contacts.moving_load import MovingLoad
from tactile.simulator.scene.scene import Scene
from tests.benchmarks.accuracy.section import Section

SIDES = (2, 4, 8, 16, 32)
FRAMES, ROUNDS = 400, 3
PROGRAM = "coherent-shear"
"""A program of the library, as a user's own."""
ASKED = ("code and events", "and the load", "and textures", "and a program")


def section() -> Section:
    """Measure a grip and a slip on arrays from 2 x 2 to 32 x 32."""
    rows = [row for side in watched(SIDES, "touch", len(SIDES)) for row in _measured(side)]
    of = {(row["side"], row["asked"]): row for row in rows}
    small, large = (of[side, "and textures"]["median us"] / of[side, ASKED[0]]["median us"] for side in (2, 8))
    answer = (
        f"Code and events of 8 x 8 taxels take {of[8, ASKED[0]]['median us']:.0f} us a frame. "
        f"Loads and textures take {large:.2g} x that ({small:.2g} x on 2 x 2 taxels), a program of your own "
        f"{_ratio(of, 8):.2g} x."
    )
    return Section("touch", "Touch", answer, _text(of), rows)


def _ratio(of: dict[Any, Any], side: int) -> float:
    return float(of[side, "and a program"]["median us"] / of[side, ASKED[0]]["median us"])


def _measured(side: int) -> list[dict[str, Any]]:
    array, frames = _frames(side)
    rows = []
    for asked in ASKED:
        times = _stages(array, frames, asked)
        middle, late = np.percentile(times, (50, 99)).tolist()
        rows.append({"side": side, "asked": asked, "median us": middle * 1e6, "p99 us": late * 1e6})
    return rows


def _frames(side: int) -> tuple[TaxelArray, list[Frame]]:
    array = TaxelArray("pad", side, side, 1.5e-3, 1.5e-3)
    path = np.array([(0.1, 0, 0, 0, 0, 0), (0.5, 0, 0, 0, 0, 0.6), (1.0, 0, 0, 0.0, 0.3, 0.6),
                     (1.5, 1e-3, 0, 0.0, 0.3, 0.6), (1.9, 1e-3, 0, 0, 0, 0.0)])  # fmt: skip
    scene = Scene("grip", FRAMES / 2, 2.0, 2.4e6, (array,), (MovingLoad(0, path),))
    return array, list(scene)


def _stages(array: TaxelArray, frames: list[Frame], asked: str) -> list[float]:
    """Seconds of every frame, the best of some runs; without loads, no load is located."""
    settings = Settings(programs=(PROGRAM,) if asked == ASKED[3] else ())
    pipeline.run(FrameStream("warm", (array,), 2.4e6, len(frames), frames), settings, ())
    return np.min([_once(array, frames, asked, settings) for _ in range(ROUNDS)], axis=0).tolist()


def _once(array: TaxelArray, frames: list[Frame], asked: str, settings: Settings) -> list[float]:
    finger, nothing = Finger(array, 2.4e6, settings), Load(validity=Validity.NO_LOAD)
    locate: Callable[[Frame], Load] = (lambda _: nothing) if asked == ASKED[0] else finger.locate
    times = []
    for raw in frames:
        start = perf_counter()
        frame = finger.calibrate(raw)
        load = locate(frame)
        finger.detect(frame, load)
        if asked in ASKED[2:]:
            finger.texture(frame, load)
        times.append(perf_counter() - start)
    return times


_TEXT = """\
A grip that slips, 400 frames on a pad; the time of each frame through the stages of the pipeline, the best of three
runs, nothing written. The program is `{program}` of the library, taken as a user's own.

| taxels | {asked} |
|{rule}|
{table}

Each cell: median, 99 of 100 frames. Frames in which no plane changes skip the detectors' steps, so the median is that
of a quiet frame and the 99th that of a busy one. Times of a loaded machine are longer; `make bench` has the races."""


def _text(of: dict[Any, Any]) -> str:
    lines = []
    for side in SIDES:
        cells = [f"{of[side, asked]['median us']:.0f}, {of[side, asked]['p99 us']:.0f} us" for asked in ASKED]
        lines.append(f"| {side} x {side} | " + " | ".join(cells) + " |")
    return _TEXT.format(
        program=PROGRAM, asked=" | ".join(ASKED), rule="---|" * len(ASKED) + "---", table="\n".join(lines)
    )
