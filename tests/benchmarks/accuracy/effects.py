"""Section 5, effects: what each adds to the time and to the truth, and effects = "auto" against all of them."""

from dataclasses import replace
from pathlib import Path
from time import thread_time
from typing import Any

import numpy as np

from cnnsim.support.command_line import watched
from cnnsim.support.toml_file import read_toml
from tactile.output.tradeoff_plot import draw_trades
from tactile.simulator.scene.auto_effects import all_effects, choose
from tactile.simulator.scene.estimate import Sample, sizes_in
from tactile.simulator.scene.file import bare_scene
from tactile.simulator.scene.scene import Scene
from tactile.simulator.scene.tradeoff import Trade, trades
from tests.benchmarks.accuracy.labels import label_points
from tests.benchmarks.accuracy.section import Section
from tests.kits.touch.random_scenes import error_of_seeds, everything, random_scene

SCENES = Path("examples/scenes")
NAMES = ("grip", "needle", "textures")
TOLERANCE = 0.02
SAMPLES = 200
FRESH = 515_000
"""Scenes from here on were never looked at when bounds were chosen."""


def section(cases: int) -> Section:
    """Measure the example scenes, and so many random ones."""
    found: dict[str, list[Trade]] = {}
    parts: dict[str, list[tuple[str, float, float]]] = {}
    for name in watched(NAMES, "effects", len(NAMES)):
        scene, _ = bare_scene(read_toml(SCENES / f"{name}.toml", "scene"), name, SCENES)
        found[name] = list(trades(scene))
        parts[name] = _parts(scene)
    tries = [_tried(np.random.default_rng(FRESH + n)) for n in watched(range(cases), "random scenes", cases)]
    rows = [
        {
            "scene": name, "tolerance": one.tolerance, "bound": one.bound, "error": one.error,
            "us a frame": one.seconds * 1e6, "ms choosing": one.choosing * 1e3, "left out": " ".join(one.left_out),
        }
        for name, trade in found.items() for one in trade
    ]  # fmt: skip
    near = {name: _at(trade, 0.03) for name, trade in found.items()}
    saved = ", ".join(f"{name} {found[name][0].seconds / one.seconds:.2g} x" for name, one in near.items())
    answer = (
        f'Effects: effects = "auto" at a tolerance of 3 % of the peak computes faster than all effects by {saved}, and '
        f"kept its tolerance in {np.mean([one['error'] <= TOLERANCE for one in tries]):.1%} of {cases} random scenes."
    )
    text = _text(found, parts, tries)
    return Section(
        "effects", "5. Effects of the skin", answer, text, rows, lambda fig: _draw(fig, found, parts), (13, 8.5)
    )


def _at(trade: list[Trade], tolerance: float) -> Trade:
    return next(one for one in trade if one.tolerance == tolerance)


def _parts(scene: Scene) -> list[tuple[str, float, float]]:
    """Every effect, typical where the scene does not say: its size with all others on, its time of a frame [s]."""
    effects = all_effects(scene)
    whole = scene.with_effects(effects)
    sizes, seconds = sizes_in(whole, effects), Sample(whole, 400).seconds(effects)
    return [(name, sizes[name].change, seconds[name]) for name, _ in effects]


def _tried(random: np.random.Generator) -> dict[str, float]:
    """Error of the choice for a random scene, over its own seed and two others, and time of computing the scenes."""
    scene = random_scene(random)
    scene = replace(scene, rate=SAMPLES / scene.duration)
    whole = everything(scene)
    _computed(whole)  # tables of layers are made once
    choosing, choice = _time(lambda: choose(scene, TOLERANCE))
    chosen, every = _time(lambda: _computed(choice.scene))[0], _time(lambda: _computed(whole))[0]
    error = error_of_seeds(choice.scene, whole, (scene.seed, 7001, 7002))
    return {
        "error": error, "bound": choice.bound, "choosing": choosing, "chosen": chosen, "all": every,
    }  # fmt: skip


def _computed(scene: Scene) -> None:
    for _ in scene.batches(0):
        pass


def _time(work: Any) -> tuple[float, Any]:
    """Time of this thread alone, for the runs are short: the best of three."""
    best = np.inf
    for _ in range(3):
        start = thread_time()
        result = work()
        best = min(best, thread_time() - start)
    return best, result


_TEXT = """\
For a tolerance `effects = "auto"` leaves out effects whose bounds together stay below it: bounds over the whole
recording, and over all seeds but one in a million of what is random. Effects that the scene does not name count at
typical strength. Errors are found over the whole recording and three seeds, against all effects on, relative to the
ideal skin's peak.

| scene | tolerance | error found | its bound | time of a frame | left out |
|---|---|---|---|---|---|
{table}

**What each effect adds**, with all others on (of what is random a bound over seeds; a dead or stuck taxel is as large
as the signal), and its share of the time of a frame:

| effect | {names} |
|{rule}|
{parts}

**Random scenes**, {cases} of them with any effect at any strength and seeds that were never looked at before: the
tolerance of {tolerance:g} was kept in {kept:.1%}, over the scene's own seed and two others; the largest error was
{worst:.2g}, and the bound was {loose:.1f} x the error in the median. A chosen scene took at most {slowest:.2f} x the
time of all effects on, {median:.2f} x in the median. Choosing took {choosing:.1f} ms, as long as {frames:.0f} of
these frames with all effects on: at {samples} frames choosing and computing together cost {sum:.2f} x in the median,
and less than all effects on in {pays:.0%}, the others being those of which little can be left out. Keep a choice with
`tactile explain SCENE --write FILE` where a scene is run again."""


def _text(found: dict[str, list[Trade]], parts: dict[str, list[tuple[str, float, float]]], tries: list[Any]) -> str:
    table = []
    for name, trade in found.items():
        for one in trade[1:]:
            ratio, left = one.seconds / trade[0].seconds, len(one.left_out)
            time = f"{one.seconds * 1e6:.3g} us, {ratio:.2f} x"
            table.append(f"| {name} | {one.tolerance:g} | {one.error:.1e} | {one.bound:.1e} | {time} | {left} |")
    lines = []
    for rows in zip(*parts.values(), strict=True):
        cells = []
        for (_, size, seconds), whole in zip(rows, parts.values(), strict=True):
            cells.append(f"{size:.2g}, {seconds / sum(one[2] for one in whole):.0%}")
        lines.append(f"| {rows[0][0]} | " + " | ".join(cells) + " |")
    ratios = [one["chosen"] / one["all"] for one in tries]
    return _TEXT.format(
        table="\n".join(table), names=" | ".join(parts), rule="---|" * len(parts) + "---", parts="\n".join(lines),
        cases=len(tries), tolerance=TOLERANCE, kept=np.mean([one["error"] <= TOLERANCE for one in tries]),
        worst=max(one["error"] for one in tries),
        loose=np.median([one["bound"] / one["error"] for one in tries if one["error"] > 0]),
        slowest=max(ratios), median=np.median(ratios), choosing=np.median([one["choosing"] for one in tries]) * 1e3,
        samples=SAMPLES, sum=np.median([(one["choosing"] + one["chosen"]) / one["all"] for one in tries]),
        pays=np.mean([one["choosing"] + one["chosen"] < one["all"] for one in tries]),
        frames=np.median([one["choosing"] for one in tries]) / np.median([one["all"] / SAMPLES for one in tries]),
    )  # fmt: skip


def _draw(figure: Any, found: dict[str, list[Trade]], parts: dict[str, list[tuple[str, float, float]]]) -> None:
    above, below = figure.subplots(2, len(found))
    for (name, trade), one, other in zip(found.items(), above, below, strict=True):
        draw_trades(trade, one, name)
        places = [(seconds * 1e6, max(size, 1e-4)) for _, size, seconds in parts[name]]
        other.plot(*zip(*places, strict=True), ".", color="C0")
        other.set(xscale="log", yscale="log", title=f"{name}: what each effect adds")
        other.set(xlabel="time of a frame [us]", ylabel="size over the peak")
        other.margins(x=0.25)
        other.grid(alpha=0.3, which="both")
    for (name, some), axes in zip(parts.items(), below, strict=True):  # when all axes have their sizes
        places = [(seconds * 1e6, max(size, 1e-4)) for _, size, seconds in some]
        label_points(axes, places, [effect.replace("_", " ") for effect, _, _ in parts[name]])
