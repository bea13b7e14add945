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
from tactile.simulator.choice.auto_effects import all_effects, choose
from tactile.simulator.choice.estimate import Sample, Size, sizes_in
from tactile.simulator.choice.tradeoff import Trade, trades
from tactile.simulator.scene.scene import Scene
from tactile.simulator.scene_file.file import bare_scene
from tests.benchmarks.accuracy.labels import label_points
from tests.benchmarks.accuracy.section import Section
from tests.kits.touch.random_scenes import error_of_seeds, everything, random_scene

Part = tuple[str, Size, float]
"""An effect, its size, and its time of a frame [s]."""
SCENES = Path("examples/scenes")
NAMES = ("grip", "needle", "textures")
TOLERANCE = 0.02
SAMPLES = 200
ONE_RUN, REUSED = "one run", "reused"
ROUNDS = 5
"""Turns of which the best counts."""
FRESH = 515_000
"""Scenes from here on were never looked at when bounds were chosen."""


def section(cases: int) -> Section:
    """Measure the example scenes, and so many random ones."""
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
    kept = np.mean([one[REUSED]["error"] <= TOLERANCE for one in tries])
    answer = (
        f'Effects: effects = "auto" at a tolerance of 3 % of the peak computes faster than all effects by {saved}, and '
        f"kept one of {TOLERANCE:.0%} in {kept:.1%} of {cases} random scenes, each with three seeds."
    )
    text = _text(found, parts, tries)
    return Section(
        "effects", "5. Effects of the skin", answer, text, rows, lambda fig: _draw(fig, found, parts), (13, 8.5)
    )


def _at(trade: list[Trade], tolerance: float) -> Trade:
    return next(one for one in trade if one.tolerance == tolerance)


def _parts(scene: Scene) -> list[Part]:
    """Every effect, typical where the scene does not say: its size with all others on, its time of a frame [s]."""
    effects = all_effects(scene)
    whole = scene.with_effects(effects)
    sizes, seconds = sizes_in(whole, effects), Sample(whole, 400).seconds(effects)
    return [(name, sizes[name], seconds[name]) for name, _ in effects]


def _tried(random: np.random.Generator) -> dict[str, dict[str, float]]:
    """What a choice for one run of a random scene does, and one that is reused: see ``_judged``."""
    scene = random_scene(random)
    scene = replace(scene, rate=SAMPLES / scene.duration)
    whole = everything(scene)
    _computed(whole)  # tables of layers are made once
    return {name: _judged(scene, whole, name == REUSED) for name in (ONE_RUN, REUSED)}


def _judged(scene: Scene, whole: Scene, reused: bool) -> dict[str, float]:
    """Error of a choice, over the scene's own seed and two others, and times over that of all effects on."""
    every = choosing = run = np.inf
    _computed(choose(replace(scene), TOLERANCE, reused).scene)  # its tables, too
    # by turns, for other work comes and goes, and both runs after a choice, for its code and theirs do not fit into the
    # processor's first cache; a copy of a scene knows nothing yet, and what a choice finds out is there for the one run
    # after it
    for _ in range(ROUNDS):
        choose(replace(scene), TOLERANCE, reused)
        every = min(every, _time(lambda: _computed(replace(whole)))[0])
        spent, choice = _time(lambda: choose(replace(scene), TOLERANCE, reused))
        choosing, run = min(choosing, spent), min(run, _time(partial(_computed, choice.scene))[0])
    error = error_of_seeds(choice.scene, whole, (scene.seed, 7001, 7002))
    left = len(choice.off - choice.bounds.zero)
    return {
        "error": error, "bound": choice.bound, "left out": left, "choosing": choosing, "run": run / every,
        "sum": (choosing + run) / every,
    }  # fmt: skip


def _computed(scene: Scene) -> None:
    for _ in scene.batches(0):
        pass


def _time(work: Any) -> tuple[float, Any]:
    """Time of this thread alone, for the runs are short."""
    start = thread_time()
    result = work()
    return thread_time() - start, result


_TEXT = """\
For a tolerance `effects = "auto"` leaves out effects whose bounds together stay below it: bounds over the whole
recording, and over all seeds but one in a million of what is random. Effects that the scene does not name count at
typical strength. Errors are found over the whole recording and three seeds, against all effects on, relative to the
ideal skin's peak.

| scene | tolerance | error found | its bound | time of a frame | left out |
|---|---|---|---|---|---|
{table}

**What each effect adds**, with all others on, and its share of the time of a frame. Of what is random it is a bound
over seeds, and of what is smaller than the steps of the converter one wherever these lie; a dead or stuck taxel is as
large as the signal:

| effect | {names} |
|{rule}|
{parts}

**Random scenes**, {cases} of them, {samples} frames each, with any effect at any strength and seeds that were never
looked at before, at a tolerance of {tolerance:g}. A choice for one run is made by bounds, and only where it may pay, told
by the forces, the sizes of the arrays and what the effects take alone, and else leaves all on; unless the scene says
another accuracy than the usual one it also computes the field to a twentieth of the tolerance, 1e-3 at most, or two or
five times as roughly where so much of the tolerance is left. One that is reused
(`tactile explain SCENE --write FILE`) is always made, with trials of the effects in doubt. Errors are the largest over the scene's own seed and two
others; times are relative to those of all effects on, by turns.

| choice | tolerance kept | largest error | bound over error, median | something left out | choosing, median | run, median | run, most | choosing and run, median | most | less than all on |
|---|---|---|---|---|---|---|---|---|---|---|
{tries}"""  # noqa: E501  # a row of a table is one line


def _row(name: str, tries: list[dict[str, float]]) -> str:
    """How the choices of a kind did over all scenes."""
    of = {key: np.array([one[key] for one in tries]) for key in tries[0]}
    wrong = of["error"] > 0
    loose = f"{np.median(of['bound'][wrong] / of['error'][wrong]):.1f}" if wrong.any() else "-"
    return (
        f"| {name} | {np.mean(of['error'] <= TOLERANCE):.1%} | {of['error'].max():.2g} | {loose} "
        f"| {np.mean(of['left out'] > 0):.0%} | {np.median(of['choosing']) * 1e3:.2g} ms "
        f"| {np.median(of['run']):.2f} x | {of['run'].max():.2f} x "
        f"| {np.median(of['sum']):.2f} x | {of['sum'].max():.2f} x | {np.mean(of['sum'] < 1):.0%} |"
    )


def _text(found: dict[str, list[Trade]], parts: dict[str, list[Part]], tries: list[dict[str, dict[str, float]]]) -> str:
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
            cells.append(f"{'<= ' * size.at_most}{size.change:.2g}, {seconds / sum(one[2] for one in whole):.0%}")
        lines.append(f"| {rows[0][0]} | " + " | ".join(cells) + " |")
    return _TEXT.format(
        table="\n".join(table), names=" | ".join(parts), rule="---|" * len(parts) + "---", parts="\n".join(lines),
        cases=len(tries), tolerance=TOLERANCE, samples=SAMPLES,
        tries="\n".join(_row(name, [one[name] for one in tries]) for name in (ONE_RUN, REUSED)),
    )  # fmt: skip


def _draw(figure: Any, found: dict[str, list[Trade]], parts: dict[str, list[Part]]) -> None:
    above, below = figure.subplots(2, len(found))
    for (name, trade), one, other in zip(found.items(), above, below, strict=True):
        draw_trades(trade, one, name)
        places = [(seconds * 1e6, max(size.change, 1e-4)) for _, size, seconds in parts[name]]
        other.plot(*zip(*places, strict=True), ".", color="C0")
        other.set(xscale="log", yscale="log", title=f"{name}: what each effect adds")
        other.set(xlabel="time of a frame [us]", ylabel="size over the peak")
        other.margins(x=0.25)
        other.grid(alpha=0.3, which="both")
    for (name, some), axes in zip(parts.items(), below, strict=True):  # when all axes have their sizes
        places = [(seconds * 1e6, max(size.change, 1e-4)) for _, size, seconds in some]
        label_points(axes, places, [effect.replace("_", " ") for effect, _, _ in parts[name]])
