"""Files of trained templates: template files with examples, margin and source, a program of several, and the record."""

import json
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from cnnsim.learning.train import Training, outputs
from cnnsim.library.entry import Example, LibraryEntry
from cnnsim.library.write import template_text, toml_value
from cnnsim.network.boundary import boundary_value, parse_boundary
from cnnsim.prototyping.robust.margin import margin_of
from cnnsim.support.command_files import check_free, own_files
from cnnsim.support.files import write_text

TOLERANCE = 1e-3
EXAMPLES = 2
"""Most pairs that become worked examples of a template file, the smallest ones."""


def record_path(folder: Path, name: str) -> Path:
    """Return the path of a training's record."""
    return folder / f"{name}-training.json"


def trained_paths(folder: Path, name: str, stages: int) -> list[Path]:
    """Return the paths of the files of a training: its templates, and the program of several."""
    if stages == 1:
        return [folder / f"{name}.toml"]
    return [*(folder / f"{name}-{n + 1}.toml" for n in range(stages)), folder / "programs" / f"{name}.toml"]


def write_training(training: Training, folder: Path, *, overwrite: bool) -> list[Path]:
    """See `Training.write`."""
    task = training.task
    paths = trained_paths(folder, task.name, len(task.stages))
    check_free(*paths, replace=overwrite)
    texts = [template_text(entry) for entry in entries_of(training)]
    texts += [_program_text(training)] if len(task.stages) > 1 else []
    for path, text in zip(paths, texts, strict=True):
        write_text(path, text, replace=overwrite, follow=False)
    record = record_path(folder, task.name)
    with own_files():
        write_text(record, json.dumps(_record(training), indent=1), replace=True)
    return [*paths, record]


def entries_of(training: Training) -> list[LibraryEntry]:
    """Return the trained templates as library entries, with margin, source and, if all is right, worked examples."""
    task, last, found = training.task, len(training.templates) - 1, []
    colour, around = "binary" if task.binary else "gray", parse_boundary(task.boundary)
    how = f"{training.wrong} of {training.cells} cells are wrong" if task.binary else f"RMS error {training.error:.3g}"
    snapped = f", weights in steps of {training.snapped:g}" if training.snapped else ""
    for number, (stage, template) in enumerate(zip(task.stages, training.templates, strict=True)):
        part = f"Stage {number + 1} of {last + 1}, trained" if last else "Trained"
        entry = LibraryEntry(
            template.name, f"{part} on {len(task.pairs)} pairs of pictures; {how}.",
            f"Trained by the gradient of the transient, seed {task.seed}{snapped}", template, stage.input,
            stage.initial_state, around,
            "settled" if task.binary and task.frame_time is None else stage.duration,
            ("trained", "uncoupled" if template.uncoupled else "coupled", colour),
            examples=() if training.wrong else _examples(training, number),
            note="Its outputs for other pictures are not proved.", frame_time=task.frame_time,
        )  # fmt: skip
        found.append(replace(entry, margin=margin_of(entry).value))
    return found


def _examples(training: Training, number: int) -> tuple[Example, ...]:
    """Return the smallest pairs as a stage sees them; the output of a grey or inner stage is its own."""
    task, found = training.task, []
    if task.times and task.times[-1] != task.stages[0].duration:
        return ()  # an example has the output at the end
    for pair in sorted(task.pairs, key=lambda pair: pair.picture.size)[:EXAMPLES]:
        planes = [pair.picture, *outputs(task, training.templates, pair.picture, pair.given)]
        stage, exact = task.stages[number], task.binary and number == len(task.stages) - 1
        y = pair.target if exact else np.round(planes[number + 1], 6)
        if task.times:
            y = y[-1]
        second = pair.given if "given" in (stage.input, stage.initial_state) else None
        found.append(Example(np.round(planes[number], 6), second, y, tolerance=None if exact else TOLERANCE))
    return tuple(found)


def _program_text(training: Training) -> str:
    """Return the program that runs the stages one after the other."""
    task, templates = training.task, training.templates
    planes = [f"stage_{number + 1}" for number in range(len(templates))]
    second = any("given" in (stage.input, stage.initial_state) for stage in task.stages)
    inputs = ["picture", "given"] if second else ["picture"]
    lines = [
        f"name = {toml_value(task.name)}",
        f"summary = {toml_value(f'{len(templates)} templates, trained on {len(task.pairs)} pairs of pictures.')}",
        f"lam = {toml_value([*inputs, *planes])}", f"inputs = {toml_value(inputs)}",
        f"outputs = {toml_value(planes[-1:])}",
    ]  # fmt: skip
    for stage, t in zip(task.stages, templates, strict=True):
        around = boundary_value(parse_boundary(task.boundary))
        data = {"A": t.A.tolist(), "B": t.B.tolist(), "z": t.z, "boundary": around,
                "duration": "settled" if task.binary else stage.duration}  # fmt: skip
        lines += ["", f"[templates.{t.name}]", *(f"{key} = {toml_value(value)}" for key, value in data.items())]
    for stage, t, before, plane in zip(task.stages, templates, ["picture", *planes], planes, strict=False):
        u, x = (before if source == "picture" else source for source in (stage.input, stage.initial_state))
        step = {"template": t.name, "input": u, "state": x, "to": plane}
        lines += ["", "[[step]]", *(f"{key} = {toml_value(value)}" for key, value in step.items())]
    return "\n".join(lines) + "\n"


def _record(training: Training) -> dict[str, Any]:
    task = training.task
    keys = ("loss", "noise", "mismatch", "decay", "sparsity", "largest", "starts", "iterations", "seed")
    return {
        "task": task.digest, "finished": True, "name": task.name, "pairs": len(task.pairs),
        "options": {key: getattr(task, key) for key in keys}, "starts": training.starts, "wrong": training.wrong,
        "cells": training.cells, "error": training.error, "snapped": training.snapped, "seconds": training.seconds,
        "curve": training.curve,
    }  # fmt: skip
