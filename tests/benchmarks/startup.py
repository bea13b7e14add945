"""How long a new process takes to import the package, and to its first template, compiled code being on disk.

Python's own compiled files as well: where the surroundings forbid to write them, 0.2 s go into reading sources.
"""

import os
import subprocess
import sys

from tests.benchmarks.race import Row

TIMED = "import time; start = time.perf_counter(); {}; print(time.perf_counter() - start)"
FIRST = "import numpy; from cnnsim import run; run('{}', numpy.eye(64) * 2 - 1)"


def measure(rounds: int) -> list[Row]:
    """Return the best of some new processes, each timed from within, after the interpreter's start."""
    texts = {"import cnnsim": "import cnnsim", "edge": FIRST.format("edge"),
             "hole-filler": FIRST.format("hole-filler")}  # fmt: skip
    best = dict.fromkeys(texts, float("inf"))
    settings = {name: value for name, value in os.environ.items() if name != "PYTHONDONTWRITEBYTECODE"}
    for _ in range(rounds + 1):
        for name, text in texts.items():
            call = [sys.executable, "-c", TIMED.format(text)]
            done = subprocess.run(call, check=True, env=settings, stdout=subprocess.PIPE, text=True)
            best[name] = min(best[name], float(done.stdout))
    wanted = {"import cnnsim": "< 0.3"}
    label = {"import cnnsim": "import cnnsim", "edge": "new process, first run of edge",
             "hole-filler": "new process, first run of hole-filler"}  # fmt: skip
    return [Row(label[name], "cpu", s, "s", wanted.get(name, "< 1")) for name, s in best.items()]
