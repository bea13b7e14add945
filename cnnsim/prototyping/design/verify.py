"""Verifies a design by running it on all windows."""

from pathlib import Path

import numpy as np

from cnnsim.backends.base import Backend
from cnnsim.network import fixed
from cnnsim.program.file import load_program
from cnnsim.program.machine import UniversalMachine
from cnnsim.program.program import Program
from cnnsim.prototyping.design.design import Design
from cnnsim.prototyping.design.rule import WindowRule
from cnnsim.support import Floats
from cnnsim.transient import run_transient


def all_windows(rule: WindowRule) -> tuple[Floats, Floats | None]:
    """Return planes (n, 3, 3) with every window of a rule, and the initial states if they count."""
    rows = rule.rows.astype(np.float64)
    state = np.repeat(rows[:, 9], 9).reshape(-1, 3, 3) if rule.with_state else None
    return rows[:, :9].reshape(-1, 3, 3), state


def wrong_windows(design: Design, program: Path | None = None, backend: str | Backend = "cpu") -> list[int]:
    """Run a design on all windows (its program file, or its single template); return the rows with a wrong answer."""
    rule = design.rule
    picture, state = all_windows(rule)
    if program is not None:
        result = run_program(load_program(program), picture, state, backend)
    else:
        start = np.zeros_like(picture) if state is None else state
        template = design.parts[0].template("single")
        result = run_transient(template, state=start, input=picture, boundary=fixed(-1), backend=backend).y
    colour = np.where(result[:, 1, 1] > 0, 1, -1)
    return [int(i) for i in np.flatnonzero(colour * rule.table < 0)]


def run_program(program: Program, picture: Floats, state: Floats | None, backend: str | Backend = "cpu") -> Floats:
    """Run a designed program and return its result, black +1 and white -1."""
    planes = {"picture": picture} if state is None else {"picture": picture, "state": state}
    return np.where(UniversalMachine(backend).run(program, **planes)["result"], 1.0, -1.0)
