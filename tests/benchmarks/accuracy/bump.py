"""Section 3, a bump of finite elements: element, mesh, small against finite strain, and what the cache saves."""

import os
import tempfile
from pathlib import Path
from time import perf_counter
from typing import Any
from unittest.mock import patch

import numpy as np

from cnnsim.support import Floats
from cnnsim.support.command_line import watched
from tactile.bump.body import Body
from tactile.bump.kinematics import PRESSED
from tactile.bump.law import Displacement, Mixed
from tactile.bump.mesh import half_section
from tactile.bump.plate import plate_constraint, respond
from tactile.bump.probe import Probe
from tactile.bump.response import finite_strain, small_strain
from tactile.bump.shape import Shape
from tactile.elastic.medium import Medium
from tests.benchmarks.accuracy.section import Section

SHAPE = Shape(thickness=1e-3, reach=2e-3)
DEPTH = 0.2e-3
RUBBER = Medium(1.0, 0.499)
FINENESS = (0.5, 0.7, 1.0, 1.4, 2.0)
FINEST = 3.0
POINTS = np.stack([np.linspace(0, 0.6e-3, 13), np.full(13, DEPTH)], axis=-1)
KINDS: dict[str, tuple[type[Mixed | Displacement], int]] = {
    "mixed, degree 2": (Mixed, 2), "displacement, degree 2": (Displacement, 2),
    "displacement, degree 1": (Displacement, 1),
}  # fmt: skip


def section() -> Section:
    """Measure them on a small body."""
    rows: list[dict[str, Any]] = []
    exact = _solved(Mixed, 2, FINEST)[0]
    runs = [(kind, fineness) for kind in KINDS for fineness in FINENESS]
    for kind, fineness in watched(runs, "finite elements", len(runs)):
        strain, unknowns, seconds = _solved(*KINDS[kind], fineness)
        error = float(np.abs(strain - exact).max() / np.abs(exact).max())
        rows.append(_row(kind, fineness, unknowns, error, seconds))
    rows += _strains()
    cold, warm = _cache()
    rows += [_row("table, computed", 1.0, 0, 0.0, cold), _row("table, from the cache", 1.0, 0, 0.0, warm)]
    mixed = next(row for row in rows if row["way"] == "mixed, degree 2" and row["fineness"] == 1.0)
    locked = next(row for row in rows if row["way"] == "displacement, degree 1" and row["fineness"] == 1.0)
    answer = (
        f"Mixed elements on the standard mesh are off by {mixed['error']:.1%} in {mixed['seconds']:.2g} s. "
        f"Plain elements of degree 1 lock and are off by {locked['error']:.0%}. "
        f"A bump that was computed once comes from the cache in {warm * 1e3:.2g} ms instead of {cold:.2g} s."
    )
    return Section("bump", "Bump by finite elements", answer, _text(rows), rows)


def _row(way: str, fineness: float, unknowns: int, error: float, seconds: float) -> dict[str, Any]:
    return {"way": way, "fineness": fineness, "unknowns": unknowns, "error": error, "seconds": seconds}


def _solved(law: type[Mixed | Displacement], degree: int, fineness: float) -> tuple[Floats, int, float]:
    """Strain per newton under a plate that presses, the number of unknowns, seconds."""
    start = perf_counter()
    body = Body(half_section(SHAPE, fineness), PRESSED, law(RUBBER), degree)
    constraint = plate_constraint(body, SHAPE, "press")
    state = respond(body, constraint)
    force = constraint.force(body.stiffness(*body.rest()) @ state)
    strain = Probe(body, POINTS).strain(state) / force
    return strain, body.size, perf_counter() - start


def _strains() -> list[dict[str, Any]]:
    """Normal strain per newton at finite strain, against the table of small strain with the contact it has there."""
    start = perf_counter()
    deepest = finite_strain(SHAPE, RUBBER, DEPTH, POINTS[:, 0], 0.1e-3, 0.6)
    seconds = perf_counter() - start
    start = perf_counter()
    small = small_strain(SHAPE, RUBBER, DEPTH, POINTS[:, 0], 0.6).normal[0]
    once = perf_counter() - start
    rows = [_row("small strain, a table", 1.0, 0, 0.0, once), _row("finite strain, a table", 1.0, 0, 0.0, seconds)]
    for depth, force, normal in zip(deepest.indentations[1:], deepest.forces[1:], deepest.normal[1:], strict=True):
        gap = float(np.abs(normal / force - small).max() / np.abs(small).max())
        rows.append(_row("small strain instead of finite", depth * 1e6, 0, gap, 0.0))
    return rows


def _cache() -> tuple[float, float]:
    """Seconds of the first and of the second time that a bump is asked for."""
    from tactile.core.frame import TaxelArray
    from tactile.simulator.bump_cover import Bumps

    array, times = TaxelArray("chip", 2, 2, 1.5e-3, DEPTH), []
    with tempfile.TemporaryDirectory() as folder, patch.dict(os.environ, {"XDG_CACHE_HOME": str(Path(folder))}):
        for _ in range(2):
            start = perf_counter()
            Bumps(SHAPE, RUBBER.nu).response(array, "strain")
            times.append(perf_counter() - start)
    return times[0], times[1]


_TEXT = """\
A bump of 0.4 mm on 1 mm of rubber, Poisson's ratio 0.499, taxels 0.2 mm under its foot; the truth is the mixed
element on the mesh of fineness {finest:g}.

| element | fineness | unknowns | largest error of a strain | seconds |
|---|---|---|---|---|
{table}

Rubber hardly changes its volume: an element that knows displacements alone locks, most at degree 1. With the pressure
as an unknown of its own (Taylor and Hood) the error falls with the mesh; the scene's tables are made at fineness 2.

**Small or finite strain.** Small strain is linear in the force and one solution; finite strain follows the contact as
it grows, {ratio:.0f} x the time. What small strain, with half the bump touching, is off by:

| pressed in | {depths} |
|{rule}|
| difference over the peak | {gaps} |

**Cache.** The first scene with a bump computes its table in {cold:.2g} s, every later one of these dimensions, in
this process or another, reads it in {warm:.2g} ms."""


def _text(rows: list[dict[str, Any]]) -> str:
    table = [
        f"| {r['way']} | {r['fineness']:g} | {r['unknowns']} | {r['error']:.1e} | {r['seconds']:.2g} |"
        for r in rows if r["way"] in KINDS
    ]  # fmt: skip
    by_way = {row["way"]: row for row in rows}
    gaps = [row for row in rows if row["way"] == "small strain instead of finite"]
    return _TEXT.format(
        finest=FINEST, table="\n".join(table), rule="---|" * len(gaps) + "---",
        ratio=by_way["finite strain, a table"]["seconds"] / by_way["small strain, a table"]["seconds"],
        depths=" | ".join(f"{row['fineness']:.3g} um" for row in gaps),
        gaps=" | ".join(f"{row['error']:.1%}" for row in gaps),
        cold=by_way["table, computed"]["seconds"], warm=by_way["table, from the cache"]["seconds"] * 1e3,
    )  # fmt: skip
