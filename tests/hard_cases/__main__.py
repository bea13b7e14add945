"""Run all hard cases and write the table: ``python -m tests.hard_cases [-o FOLDER]``; exit status 1 if one failed."""

import argparse
import os
import sys
from pathlib import Path

import numpy as np

from cnnsim import InputError
from cnnsim.backends.base import Backend
from cnnsim.support.command_line import watched
from tests.hard_cases import FAMILIES
from tests.hard_cases.case import HardCase

_HEAD = """# Hard cases

Rebuilt by `make hard-cases`, and run by the tests on every backend in float32 and float64. Each case has an answer in
high precision or in closed form; the figures are the largest distances from it. The naive form is the
straightforward computation: where the table says "fails", it must exceed the bound.
"""


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


def main() -> None:
    """Write the page; the exit status is 1 if a case failed."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("-o", "--output", type=Path, default=Path("docs"), help="where hard-cases.md goes")
    given = parser.parse_args()
    os.environ.setdefault("CNNSIM_POCL_PROCESSOR", "auto")  # without it PoCL may build nothing
    from cnnsim.backends import get

    where = {"cpu, float64": get("cpu", "float64"), "cpu, float32": get("cpu", "float32")}
    lines = [_HEAD]
    for family, cases in FAMILIES.items():
        lines += [f"## {family.capitalize()}", "", f"| case | why it is hard | bound | {' | '.join(where)} | naive |"]
        lines.append("|---" * (4 + len(where)) + "|")
        for case in watched(cases, family, len(cases)):
            ours = " | ".join(measured(case, backend) for backend in where.values())
            bound = (case.refused and f'"{case.refused}"') or f"{case.bound:.0e}"
            lines.append(f"| {case.name} | {case.why} | {bound} | {ours} | {naive(case)} |")
        lines.append("")
    given.output.mkdir(parents=True, exist_ok=True)
    (given.output / "hard-cases.md").write_text("\n".join(lines), encoding="utf-8")
    failed = sum("FAILED" in line for line in lines)
    print(f"{given.output / 'hard-cases.md'} written, {failed} cases failed")
    sys.exit(failed > 0)


if __name__ == "__main__":
    main()
