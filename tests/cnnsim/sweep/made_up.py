"""A made-up kind of sweep: squares of numbers, some of which fail, kill their process, or wait."""

import os
import signal
from collections.abc import Sequence
from pathlib import Path

from cnnsim.support import InputError
from cnnsim.sweep.kind import Case, Kind, Row


def run(cases: Sequence[Case]) -> list[Row]:
    for case in cases:
        if "log" in case:
            with Path(case["log"]).open("a") as log:
                log.write(f"{case['n']} ")
        if case["n"] in case.get("fails", []):
            raise InputError(f"{case['n']} is bad; another wanted")
        if case["n"] in case.get("kills", []):
            os.kill(os.getpid(), signal.SIGKILL)
    return [{"square": case["n"] ** 2, "together": len(cases)} for case in cases]


def check(case: Case) -> None:
    if not isinstance(case["n"], int):
        raise InputError(f"n = {case['n']!r}; a whole number wanted")


KIND = Kind(
    keys={"n": "", "m": "", "fails": "", "kills": "", "log": ""}, run=run,
    group=lambda case: case["n"] if "kills" in case else case.get("m"),
    needed=("n",), check=check,
)  # fmt: skip
