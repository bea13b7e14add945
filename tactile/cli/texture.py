"""Commands for textures: train, classify, report."""

import json
from collections.abc import Callable
from dataclasses import replace as changed
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from cnnsim.support import InputError
from cnnsim.support.command_files import claim
from cnnsim.support.command_line import examples, print_json, replace_option
from cnnsim.support.files import write_text
from cnnsim.support.terminal import echo, say_table
from tactile.cli.options import FILE, JSON, LAYOUT, Finite

if TYPE_CHECKING:
    from tactile.materials.assessment import Assessment
    from tactile.materials.slide import Slide

KINDS = ("full", "figures")


def _shared(command: Callable[..., None]) -> Callable[..., None]:
    """Add the options that describe slides and their features to a command."""
    for option in reversed((
        click.option("--labels", type=FILE, help="CSV: recording, material, and what is known of sensor, start_s,"
                     " stop_s, speed_mm_s, block."),
        click.option("--window", type=int, default=128, show_default=True, help="Samples of a window."),
        click.option("--speed", type=float, help="Speed of all slides [mm/s]: spectra are then in 1/m."),
        LAYOUT,
        JSON,
    )):  # fmt: skip
        command = option(command)
    return command


class _Texture(click.Group):
    """A group of commands listed in the order of use."""

    def list_commands(self, ctx: click.Context) -> list[str]:
        return list(self.commands)


@click.group(
    cls=_Texture,
    epilog=examples(
        "tactile texture report slides/ -o out/textures",
        "tactile texture train slides/ -o out/materials.npz",
        "tactile texture classify slides/ --model out/materials.npz",
    ),
)
def texture() -> None:
    """Learn and classify materials from slides over them.

    Slides are an NPZ file of them, or recordings of any kind, each material's in a folder of its name or named
    by --labels. docs/textures.md has all of it.
    """


@texture.command(epilog=examples("tactile texture train slides/ -o out/materials.npz"))
@click.argument("folder", type=FILE)
@click.option("-o", "--output", type=FILE, required=True, help="The model's file (.npz).")
@click.option("--features", type=click.Choice(KINDS), default="full", show_default=True,
              help="The full set, or the paper's two figures.")  # fmt: skip
@replace_option
@_shared
def train(
    folder: Path, output: Path, features: str, labels: Path | None, window: int, speed: float | None,
    layout: Path | None, as_json: bool,
) -> None:  # fmt: skip
    """Learn the materials of slides, and write a model."""
    from tactile.materials.features import feature_set  # NumPy is slow to import
    from tactile.materials.fit import learner  # the same
    from tactile.materials.model import train as learn  # the same
    from tactile.materials.model_file import check_suffix, write_model  # the same

    learner("neighbors")
    check_suffix(output)
    claim(output)
    slides = _slides(folder, labels, speed, layout)
    chosen = feature_set(features, window, slides)
    _say_shear(chosen.shear)
    model, unknown = learn(slides, chosen)
    write_model(output, model)
    auroc = sum(unknown.values()) / len(unknown) if unknown else None
    if as_json:
        print_json({
            "model": str(output), "materials": model.materials, "features": model.features.names,
            "conditions": model.conditions, "unknown_auroc": auroc,
        })  # fmt: skip
        return
    of = f"{len(model.features.names)} features, {model.conditions['windows']} windows"
    echo(f"{len(model.materials)} materials of {model.conditions['slides']} slides: {of}")
    echo(f"unknown materials, each left out in turn: AUROC {_figure(auroc)}")
    echo(f"wrote {output}; its accuracy: tactile texture report {folder}")


@texture.command(epilog=examples("tactile texture classify slides/ --model out/materials.npz"))
@click.argument("source", type=FILE)
@click.option("--model", type=FILE, required=True, help="Model file of `tactile texture train`.")
@click.option("--confidence", type=Finite(0, 1), default=0.5, show_default=True,
              help="Confidence below which a material is unknown.")  # fmt: skip
@_shared
def classify(
    source: Path, model: Path, confidence: float, labels: Path | None, window: int, speed: float | None,
    layout: Path | None, as_json: bool,
) -> None:  # fmt: skip
    """Classify the materials of slides.

    SOURCE is a folder, a file of slides or a recording.
    """
    from tactile.materials.classification import strange, told_slides  # the same
    from tactile.materials.model_file import read_model  # NumPy is slow to import
    from tactile.materials.windows import cut  # the same

    known = read_model(model)
    _say_shear(known.features.shear)
    _check_window(window, known.features.window)
    table = cut(_slides(source, labels, speed, layout), known.features, known.features.window)
    notes, told = strange(known, table), told_slides(known, table, confidence)
    labelled = [one for one in told if one["known"] and one["told"] is not None]
    right = sum(one["told"] == one["known"] for one in labelled)
    if as_json:
        print_json({
            "model": str(model), "materials": known.materials, "least_confidence": confidence, "notes": notes,
            "labelled": len(labelled), "right": right, "slides": told,
        })  # fmt: skip
        return
    rows = []
    for one in told:
        said = f" (is {one['known']})" if one["known"] not in ("", one["told"]) else ""
        if one["told"] is None:
            rows.append((one["slide"], f"no window of {known.features.window} pressed samples{said}"))
        else:
            rows.append((one["slide"], f"{one['told']}, confidence {one['confidence']:.2f}{said}"))
    say_table(rows)
    if labelled:
        echo(f"{right} of {len(labelled)} slides with a known material are right")
    for note in notes:
        echo(f"note: {note}", err=True)


@texture.command(
    epilog=examples("tactile texture report slides/ -o out/textures", "tactile texture report slides/ --json")
)
@click.argument("folder", type=FILE)
@click.option("-o", "--output", type=FILE, help="Folder for figures.png, confusion.png and report.json.")
@replace_option
@_shared
def report(
    folder: Path, output: Path | None, labels: Path | None, window: int, speed: float | None, layout: Path | None,
    as_json: bool,
) -> None:  # fmt: skip
    """Measure how well materials are classified.

    By cross-validation over the slides in FOLDER.

    Windows are tried by slide, by block of slides, at another place of the slides, and with each material left out
    as an unknown one; for the paper's two figures and the full set.
    """
    from tactile.materials.assessment import assess  # NumPy is slow to import
    from tactile.materials.features import feature_set  # the same
    from tactile.materials.fit import learner  # the same
    from tactile.materials.model import hop  # the same
    from tactile.materials.windows import cut  # the same

    learner("neighbors")
    names = ("figures.png", "confusion.png", "report.json")
    claim(*(output / name for name in names) if output is not None else ())
    slides = _slides(folder, labels, speed, layout)
    found, tables = [], {}
    shear = feature_set("full", window, slides).shear
    _say_shear(shear)
    for kind in KINDS if shear else KINDS[:1]:
        features = feature_set(kind, window, slides)
        tables[kind] = cut(slides, features, hop(features))
        found.append(assess(tables[kind], features.kind, window))
    full = tables["full"]
    side_by_side = int((full.start % window == 0).sum())
    facts = {
        "folder": str(folder), "slides": len(slides), "materials": len(found[0].materials), "window": window,
        "windows": len(full.values), "windows_side_by_side": side_by_side, "windows_left_out": full.dropped,
        "results": [one.plain() for one in found],
    }  # fmt: skip
    if output is not None:
        _write(output, facts, found, full if shear else None, folder.name)
    if as_json:
        print_json(facts)
    else:
        windows = f"{side_by_side} windows of {window} samples side by side"
        echo(f"{facts['materials']} materials, {len(slides)} slides, {windows}")
        _print(found)
    if output is not None:
        written = names if shear else names[1:]
        echo(f"wrote {', '.join(str(output / name) for name in written)}", err=as_json)


def _slides(path: Path, labels: Path | None, speed: float | None, layout: Path | None) -> "list[Slide]":
    from tactile.materials.slide_folder import read_slides
    from tactile.materials.slide_labels import read_slide_labels

    slides = read_slides(path, None if labels is None else read_slide_labels(labels), layout)
    return slides if speed is None else [changed(one, speed=speed * 1e-3) for one in slides]


def _say_shear(shear: bool) -> None:
    if not shear:
        echo("no shear: the normal channel alone", err=True)


def _check_window(asked: int, learned: int) -> None:
    given = click.get_current_context().get_parameter_source("window")
    if given is click.core.ParameterSource.COMMANDLINE and asked != learned:
        raise InputError(f"--window {asked}; the model has windows of {learned} samples, leave it out")


def _write(folder: Path, facts: dict[str, Any], found: "list[Assessment]", table: Any, title: str) -> None:
    from tactile.materials.plot import draw_confusion, draw_figures

    if table is not None:  # slides without shear have no figures
        draw_figures(table, title, folder / "figures.png")
    draw_confusion(found[0], f"{title}, full set", folder / "confusion.png")
    write_text(folder / "report.json", json.dumps(facts, indent=1) + "\n")


def _print(found: "list[Assessment]") -> None:
    rows = (
        ("other slides of the same recordings", [one.by_slide for one in found]),
        ("other blocks of slides", [one.by_block for one in found]),
        ("another place of the slides", [one.by_place for one in found]),
        ("by chance", [1 / len(one.materials) for one in found]),
        ("AUROC of unknown materials, mean", [one.auroc for one in found]),
        ("AUROC of unknown materials, least", [min(one.unknown.values(), default=None) for one in found]),
    )
    echo()
    echo(f"{'share of windows classified right':<36}" + "".join(f"{_name(one.kind):>14}" for one in found))
    for name, values in rows:
        echo(f"{name:<36}" + "".join(f"{_figure(value):>14}" for value in values))


def _name(kind: str) -> str:
    return {"full": "full set", "figures": "two figures"}[kind]


def _figure(value: float | None) -> str:
    return "-" if value is None else f"{value:.3f}"
