"""Section 5, effects: what each adds to the time and to the truth, and effects = "auto" against all of them."""

from dataclasses import replace
from functools import partial
from pathlib import Path
from time import thread_time
from typing import Any

import numpy as np

from cnnsim.support.command_line import watched
from cnnsim.support.toml_file import read_toml
from tactile.output.tradeoff_plot import draw_trades
from tactile.simulator.auto_effects import choose
from tactile.simulator.scene.scene import Scene
from tactile.simulator.scene_file.file import bare_scene
from tactile.simulator.sizes import Sample, Size, sizes_in
from tactile.simulator.tradeoff import Trade, trades
from tests.benchmarks.accuracy.section import Section
from tests.kits.touch.random_scenes import error_of_seeds, random_scene, random_touch

Part = tuple[str, Size, float]
"""An effect, its size, and its time of a frame [s]."""
SCENES = Path("examples/scenes")
NAMES = ("needle", "textures")
TOLERANCE = 0.02
SAMPLES = (200, 2000)
ROUNDS = 5
"""Timed runs, of which the best counts."""
FRESH = 515_000
"""First seed: scenes that were not used when bounds were chosen."""


def section(cases: int) -> Section:
    """Measure the example scenes and ``cases`` random scenes."""
    found: dict[str, list[Trade]] = {}
    parts: dict[str, list[Part]] = {}
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
    kept = np.mean([one["error"] <= TOLERANCE for tried in tries for one in tried.values()])
    answer = (
        f'At a tolerance of 3 % of the peak, effects = "auto" is faster than all effects: {saved}. '
        f"It kept a tolerance of {TOLERANCE:.0%} in {kept:.1%} of {cases} random scenes."
    )
    text = _text(found, parts, tries)
    return Section("effects", "Effects of the skin", answer, text, rows, lambda fig: _draw(fig, found), (11, 4.2), _SEE)


def _at(trade: list[Trade], tolerance: float) -> Trade:
    return next(one for one in trade if one.tolerance == tolerance)


def _parts(scene: Scene) -> list[Part]:
    """Every effect of a scene: its size with all others on, its time per frame [s]."""
    sizes, seconds = sizes_in(scene, scene.effects), Sample(scene, 400).seconds(list(scene.effects))
    return [(name, sizes[name], seconds[name]) for name, _ in scene.effects]


def _tried(random: np.random.Generator) -> dict[int, dict[str, float]]:
    """The choice for a random scene, by its number of frames: see ``_judged``."""
    scene = random_touch(random) if random.random() < 0.5 else random_scene(random)
    return {frames: _judged(replace(scene, rate=frames / scene.duration)) for frames in SAMPLES}


def _judged(scene: Scene) -> dict[str, float]:
    """Error of a choice, over the scene's own seed and two others, and times over that of all effects."""
    for one in (scene, choose(scene, TOLERANCE).scene):  # tables of layers are made once
        _computed(one)
    every = choosing = run = np.inf
    for _ in range(ROUNDS):
        every = min(every, _time(lambda: _computed(replace(scene)))[0])
        spent, choice = _time(lambda: choose(replace(scene), TOLERANCE))
        choosing, run = min(choosing, spent), min(run, _time(partial(_computed, choice.scene))[0])
    error = error_of_seeds(choice.scene, scene, (scene.seed, 7001, 7002))
    return {
        "error": error, "bound": choice.bound, "left out": len(choice.left_out), "choosing": choosing,
        "run": run / every, "sum": (choosing + run) / every,
    }  # fmt: skip


def _computed(scene: Scene) -> None:
    for _ in scene.batches(0):
        pass


def _time(work: Any) -> tuple[float, Any]:
    """Time of this thread alone, for the runs are short."""
    start = thread_time()
    result = work()
    return thread_time() - start, result


_SEE = (
    "Each circle is a run at a tolerance, the line above it. No circle lies above its line. "
    "A larger tolerance takes less time than all effects, the dotted line."
)
_TEXT = """\
`effects = "auto"` computes the field with an error of a third of the tolerance, and drops effects whose upper bounds fit
into the rest: over the whole recording, and for all seeds but one in a million. Errors are measured over the whole
recording and three seeds, against all effects of the scene, relative to the ideal skin's peak.

| scene | tolerance | measured error | its bound | time of a frame | dropped |
|---|---|---|---|---|---|
{table}

**Size of each effect** with all others on, and its share of the time of a frame; random effects, and effects smaller
than the steps of the converter, by an upper bound:

{parts}

**Random scenes**, {cases} of them, points and bodies on 2 x 2 to 8 x 8 taxels, with any effect at any strength, at a
tolerance of {tolerance:g}. Errors are the largest over the scene's own seed and two others; times are relative to those
of all effects, in alternating runs.

| frames | tolerance kept | largest error | bound over error, median | something dropped | choosing, median | run, median | run, most | choosing and run, median | most | less than all effects |
|---|---|---|---|---|---|---|---|---|---|---|
{tries}"""  # noqa: E501  # a row of a table is one line


def _row(frames: int, tries: list[dict[str, float]]) -> str:
    """The row of the choices for scenes with ``frames`` frames."""
    of = {key: np.array([one[key] for one in tries]) for key in tries[0]}
    wrong = of["error"] > 0
    loose = f"{np.median(of['bound'][wrong] / of['error'][wrong]):.1f}" if wrong.any() else "-"
    return (
        f"| {frames} | {np.mean(of['error'] <= TOLERANCE):.1%} | {of['error'].max():.2g} | {loose} "
        f"| {np.mean(of['left out'] > 0):.0%} | {np.median(of['choosing']) * 1e3:.2g} ms "
        f"| {np.median(of['run']):.2f} x | {of['run'].max():.2f} x "
        f"| {np.median(of['sum']):.2f} x | {of['sum'].max():.2f} x | {np.mean(of['sum'] < 1):.0%} |"
    )


def _text(found: dict[str, list[Trade]], parts: dict[str, list[Part]], tries: list[dict[int, dict[str, float]]]) -> str:
    table = []
    for name, trade in found.items():
        for one in trade[1:]:
            ratio, left = one.seconds / trade[0].seconds, len(one.left_out)
            time = f"{one.seconds * 1e6:.3g} us, {ratio:.2f} x"
            table.append(f"| {name} | {one.tolerance:g} | {one.error:.1e} | {one.bound:.1e} | {time} | {left} |")
    lines = ["| scene | effect | size | share of the time |", "|---|---|---|---|"]
    for name, rows in parts.items():
        whole = sum(seconds for _, _, seconds in rows)
        for effect, size, seconds in rows:
            lines.append(f"| {name} | {effect} | {'<= ' * size.at_most}{size.change:.2g} | {seconds / whole:.0%} |")
    return _TEXT.format(
        table="\n".join(table), parts="\n".join(lines), cases=len(tries), tolerance=TOLERANCE,
        tries="\n".join(_row(frames, [one[frames] for one in tries]) for frames in SAMPLES),
    )  # fmt: skip


def _draw(figure: Any, found: dict[str, list[Trade]]) -> None:
    panels = figure.subplots(1, len(found), sharey=True)
    for (name, trade), axes in zip(found.items(), panels, strict=True):
        draw_trades(trade, axes, name)
        axes.get_legend().remove()
        axes.label_outer()
    figure.legend(*panels[0].get_legend_handles_labels(), fontsize=9, ncols=4, loc="outside upper center")
