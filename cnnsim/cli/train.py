"""The command `train`: templates that are learned from pairs of pictures."""

from pathlib import Path
from typing import Any

import click

from cnnsim.cli.run import json_option
from cnnsim.library.entry import LibraryEntry
from cnnsim.network import Template
from cnnsim.support.command_files import claim
from cnnsim.support.command_line import examples, print_json, replace_option
from cnnsim.support.files import writing
from cnnsim.support.terminal import echo, say

_FILE = click.Path(path_type=Path)


@click.command(
    epilog=examples(
        "cnnsim train examples/learn/edge.toml -o learned/",
        "cnnsim train examples/learn/edge.toml -o learned/ --curve learned/edge.png --replace --json",
    )
)
@click.argument("spec", type=_FILE)
@click.option("-o", "--output", type=_FILE, required=True, metavar="DIR", help="Folder for the files.")
@click.option("--curve", type=_FILE, help="Draw the objective of the best start over its iterations (PNG, SVG, PDF).")
@replace_option
@json_option
def train(spec: Path, output: Path, curve: Path | None, as_json: bool) -> None:
    """Learn templates from pairs of pictures.

    SPEC is a TOML file with [[pair]] tables (input, output, state), [[stage]] tables (A, B, z, symmetry, ...) and
    options. Weights are changed by the gradient of the whole transient until all cells are right.

    The result is a template file, of several stages also a program, and a record. The same command resumes a stopped
    training from its record.
    """
    from cnnsim.learning.files import entries_of, record_path, trained_paths
    from cnnsim.learning.spec import read_training
    from cnnsim.learning.train import train as trained

    task = read_training(spec)
    paths = trained_paths(output, task.name, len(task.stages))
    claim(*paths, curve)
    record = record_path(output, task.name)
    found = trained(task, record)
    entries = entries_of(found)
    margins = [entry.margin for entry in entries]
    written = found.write(output, replace=True)
    if curve is not None:
        _draw(found.curve, curve)
    facts: dict[str, Any] = {
        "name": task.name, "wrong": found.wrong, "cells": found.cells, "error": found.error, "starts": found.starts,
        "snapped": found.snapped, "seconds": found.seconds, "templates": [
            {"name": t.name, "A": t.A.tolist(), "B": t.B.tolist(), "z": t.z, "margin": margin}
            for t, margin in zip(found.templates, margins, strict=True)
        ], "robust": [_robust(entry) for entry in entries], "files": [str(path) for path in written],
    }  # fmt: skip
    if as_json:
        print_json(facts)
        return
    how = f"{found.wrong} of {found.cells} cells wrong" if task.binary else f"RMS error {found.error:.4g}"
    say(f"result    {how} after {found.starts} starts, {found.seconds:.3g} s of processor time", 10)
    for t, margin, robust in zip(found.templates, margins, facts["robust"], strict=True):
        say(f"template  {t.name}: {_matrix(t)}", 10)
        say(f"margin    {'none applies' if margin is None else f'{margin:g}'}; {robust}", 10)
    if found.snapped:
        say(f"snapped   weights in steps of {found.snapped:g}", 10)
    for path in (*written, *([curve] if curve else [])):
        echo(f"-> {path}")


def _matrix(template: Template) -> str:
    a, b = (" / ".join(" ".join(f"{v:.4g}" for v in row) for row in matrix) for matrix in (template.A, template.B))
    terms = "".join(
        f", term {' / '.join(' '.join(f'{v:.4g}' for v in row) for row in t.weights)}" for t in template.terms
    )
    return f"A = {a}, B = {b}, z = {template.z:.4g}{terms}"


def _robust(entry: LibraryEntry) -> str:
    """Return the robustness of a template in words; templates with wrong cells have no examples to measure it on."""
    if not entry.examples:
        return "robustness not measured"
    from cnnsim.prototyping.robust.robust import measure

    found = measure(entry, draws=10)
    return "; ".join(" ".join(row) for row in found.rows() if row[0] in ("random errors", "bits"))


def _draw(curve: tuple[float, ...], path: Path) -> None:
    from matplotlib.figure import Figure  # slow to import, and only needed for plots

    figure = Figure(figsize=(6, 4), layout="constrained")
    axes = figure.add_subplot()
    axes.semilogy(range(1, len(curve) + 1), curve)
    axes.set(xlabel="iteration", ylabel="objective")
    with writing(path) as temporary:
        figure.savefig(temporary, dpi=120)
