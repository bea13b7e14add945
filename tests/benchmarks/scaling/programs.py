"""All shipped programs on planes that lie on the disk against the dense machine, to the byte: no timing.

``python -m tests.benchmarks.scaling.programs`` (cpu and opencl, float32 and float64), ``--backend cpu skeleton life``.
"""

import argparse
from typing import Any

import numpy as np

import cnnsim
from cnnsim.library.folders import folder
from cnnsim.program.machine import UniversalMachine
from cnnsim.supersteps.engine import Engine

SHAPE, SIDE = (37, 45), 24
"""A grid that does not divide by its blocks."""


def given(program: cnnsim.Program) -> dict[str, Any]:
    """Return rectangles in noise for logic planes, multiples of 1/64 for analog ones."""
    random = np.random.default_rng(3)
    planes: dict[str, Any] = {}
    for name in program.inputs:
        if program.memory[name] == "llm":
            planes[name] = random.random(SHAPE) < 0.5
            planes[name][5:20, 8:30], planes[name][9:14, 12:22] = True, False
        else:
            planes[name] = random.integers(-64, 65, SHAPE) / 64
    return planes


def same(name: str, backend: str, dtype: Any) -> bool:
    """Return whether all results have the same bytes; twice, as some programs keep planes."""
    program = cnnsim.load_program(name)
    dense, parts = (UniversalMachine(backend, dtype, engine=engine) for engine in (None, Engine(workers=1, side=SIDE)))
    planes = given(program)
    for _ in range(2):
        wanted, found = (machine.run(program, **planes) for machine in (dense, parts))
        for key, value in wanted.items():
            if np.asarray(found[key]).tobytes() != np.asarray(value).tobytes():
                return False
        planes = {key: np.roll(plane, 2, axis=1) for key, plane in planes.items()}
    return True


def main() -> None:
    """Compare and print what differs."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("names", nargs="*", default=sorted(p.stem for p in (folder() / "programs").glob("*.toml")))
    parser.add_argument("--backend", action="append", choices=["cpu", "opencl", "reference"])
    chosen = parser.parse_args()
    for backend in chosen.backend or ("cpu", "opencl"):
        for dtype in ("float64",) if backend == "reference" else ("float32", "float64"):
            others = [name for name in chosen.names if not same(name, backend, dtype)]
            print(
                f"{backend} {dtype}: {len(chosen.names) - len(others)} of {len(chosen.names)} the same bytes", *others
            )


if __name__ == "__main__":
    main()
