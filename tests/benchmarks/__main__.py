"""Measure everything, print one table, save it: ``python -m tests.benchmarks [-o FOLDER] [--rounds N]``."""

import argparse
import os
from pathlib import Path

from tests.benchmarks import dense, kinds, less, limits, peers, report, simulator, startup, touch


def main() -> None:
    """Run all families of measurements."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("-o", "--output", type=Path, default=Path("build"), help="folder of benchmarks.json")
    parser.add_argument("--rounds", type=int, default=5, help="rounds, of which the best counts")
    given = parser.parse_args()
    os.environ.setdefault("CNNSIM_POCL_PROCESSOR", "auto")  # without it PoCL may build nothing
    n = given.rounds
    triad = limits.triad_rate(n)
    rows = [
        *dense.against_peers(2048, 50, {"cpu": ">= 3 x jax, >= 2 x numba_loop", "opencl": ">= 3.5 x jax"}, n),
        *dense.against_peers(512, 400, {"cpu": ">= 1 x jax", "opencl": ">= 1 x jax"}, n),
        *dense.templates_and_sizes(n),
        *kinds.against_linear(n),
        *less.uncoupled(triad, n),
        *less.sleep(n),
        *less.logic(triad, n),
        *touch.frames(n),
        *touch.events(n),
        *touch.inverse(triad, n),
        *simulator.frames(n),
        *simulator.summation(n),
        *startup.measure(n),
    ]
    print(f"triad {triad:.1f} GB/s; best of {n} rounds")
    print(report.table(rows))
    for package in peers.missing():
        print(f"{package}: not installed, not compared")
    report.save(rows, triad, given.output)


if __name__ == "__main__":
    main()
