"""Run all hard cases and write the table: ``python -m tests.hard_cases [-o FOLDER]``; exit status 1 if one failed."""

import argparse
import os
import re
import sys
from pathlib import Path

import numpy as np
from matplotlib.figure import Figure

from cnnsim import InputError
from cnnsim.backends.base import Backend
from cnnsim.support.command_line import watched
from tests.hard_cases import FAMILIES
from tests.hard_cases.case import HardCase

_HEAD = """# Hard cases

`make hard-cases` measures this page again. Each case has an answer in high precision or in closed form. The tests run
all cases on every backend in float32 and float64.
"""
_TABLES = """# All hard cases

The figures are the largest distances from the answer in high precision or in closed form. The naive form is the
straightforward computation: where the table says "fails", it must exceed the bound.
"""
_SEE = "Each dot is a case with a naive form. Dots below the line are more accurate than the naive form."
ROUNDING = 1e-17
"""Error that is drawn for an error of 0."""


def measured(case: HardCase, backend: Backend) -> str:
    """Return the error of ``ours`` as text, or that it is refused."""
    try:
        found = case.ours(backend)
    except InputError as error:
        return "refused" if case.refused and case.refused in str(error) else f"FAILED: {error}"
    off, bound = np.abs(found - case.truth(backend)).max(), case.bound if backend.dtype == "float64" else case.bound32
    return f"{off:.1e}" if off <= bound else f"FAILED: {off:.1e}"


def naive(case: HardCase) -> str:
    """Return the error of the naive form as text."""
    if case.naive is None or case.exact is None:
        return ""
    with np.errstate(all="ignore"):
        off = np.abs(case.naive() - case.exact()).max()
    right = (not off <= case.bound) == case.naive_fails
    return f"{off:.1e}{' fails' if case.naive_fails else ''}" if right else f"FAILED: {off:.1e}"


def write_front(output: Path, tables: str) -> None:
    """Write hard-cases.md, with the numbers of the tables, and its figure."""
    families = re.split(r"^## (.*)\n", tables, flags=re.MULTILINE)[1:]
    rows, counts = list[list[str]](), list[str]()
    for family, text in zip(families[::2], families[1::2], strict=True):
        lines = [line for line in text.splitlines() if line.startswith("| ")][1:]
        found = [[cell.strip() for cell in line.split("|")[1:-1]] for line in lines]
        refused, fails = sum("refused" in one[3] for one in found), sum("fails" in one[-1] for one in found)
        counts.append(f"| {family} | {len(found)} | {refused} | {fails} |")
        rows += found
    failed = sum("FAILED" in " ".join(cells) for cells in rows)
    refused, fails = sum("refused" in cells[3] for cells in rows), sum("fails" in cells[-1] for cells in rows)
    pairs = [(float(cells[-1].split()[0]), float(cells[3])) for cells in rows if cells[-1][:1].isdigit()]
    figure = Figure(figsize=(6, 4), layout="constrained")
    axes = figure.add_subplot()
    axes.loglog(*np.maximum(np.array(pairs), ROUNDING).T, "o", markersize=5, alpha=0.6)
    axes.axline((1e-16, 1e-16), (1, 1), color="0.5", linewidth=0.8)
    axes.set(xlabel="error of the naive form", ylabel="our error, float64")
    axes.grid(alpha=0.3)
    figure.savefig(output / "hard-cases" / "errors.png", dpi=90)
    lines = [
        _HEAD,
        f"- {len(rows) - failed} of {len(rows)} cases are within their bound.",
        f"- The naive form fails in {fails} of them.",
        f"- {refused} cases are refused with a message, such as NaN in a state.",
        "- Results of cells and templates are the same bytes on each run, with any number of threads.",
        "- The families are templates, motion, grids, inputs, the inverse, located loads, the skin and textures.",
        "", _SEE, "", "![Our error against that of the naive form](hard-cases/errors.png)", "",
        "[All cases](hard-cases/all.md) has each case, why it is hard, its bound and its errors.", "",
        "| family | cases | refused | naive form fails |", "|---|---|---|---|", *counts,
    ]  # fmt: skip
    (output / "hard-cases.md").write_text("\n".join(lines) + "\n", encoding="utf-8")


def main() -> None:
    """Write the page; the exit status is 1 if a case failed."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("-o", "--output", type=Path, default=Path("docs"), help="where hard-cases.md goes")
    given = parser.parse_args()
    os.environ.setdefault("CNNSIM_POCL_PROCESSOR", "auto")  # without it PoCL may build nothing
    from cnnsim.backends import get

    where = {"cpu, float64": get("cpu", "float64"), "cpu, float32": get("cpu", "float32")}
    lines = [_TABLES]
    for family, cases in FAMILIES.items():
        head = f"| case | why it is hard | bound | {' | '.join(where)} | naive |"
        lines += [f"## {family.capitalize()}", "", head, "|---" * (4 + len(where)) + "|"]
        for case in watched(cases, family, len(cases)):
            ours = " | ".join(measured(case, backend) for backend in where.values())
            bound = (case.refused and f'"{case.refused}"') or f"{case.bound:.0e}"
            lines.append(f"| {case.name} | {case.why} | {bound} | {ours} | {naive(case)} |")
        lines.append("")
    folder = given.output / "hard-cases"
    folder.mkdir(parents=True, exist_ok=True)
    (folder / "all.md").write_text("\n".join(lines), encoding="utf-8")
    write_front(given.output, "\n".join(lines))
    failed = sum("FAILED" in line for line in lines)
    print(f"{given.output / 'hard-cases.md'} written, {failed} cases failed")
    sys.exit(failed > 0)


if __name__ == "__main__":
    main()
