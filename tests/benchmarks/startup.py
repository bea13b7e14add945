"""How long a new process takes to import the package, and to its first template, compiled code being on disk.

Python's own compiled files as well: where the surroundings forbid to write them, 0.2 s go into reading sources.
"""

import os
import subprocess
import sys
import time

from tests.benchmarks.race import Row

FIRST = "import numpy; from cnnsim import run; run('{}', numpy.eye(64) * 2 - 1)"


def measure(rounds: int) -> list[Row]:
    """Return the best of some new processes, a bare interpreter's start taken off."""
    texts = {"bare": "pass", "import cnnsim": "import cnnsim", "edge": FIRST.format("edge"),
             "hole-filler": FIRST.format("hole-filler")}  # fmt: skip
    best = dict.fromkeys(texts, float("inf"))
    settings = {name: value for name, value in os.environ.items() if name != "PYTHONDONTWRITEBYTECODE"}
    for _ in range(rounds + 1):
        for name, text in texts.items():
            start = time.perf_counter()
            subprocess.run([sys.executable, "-c", text], check=True, env=settings)
            best[name] = min(best[name], time.perf_counter() - start)
    bare = best.pop("bare")
    wanted = {"import cnnsim": "< 0.3"}
    label = {"import cnnsim": "import cnnsim", "edge": "new process, first run of edge",
             "hole-filler": "new process, first run of hole-filler"}  # fmt: skip
    return [Row(label[name], "cpu", s - bare, "s", wanted.get(name, "< 1")) for name, s in best.items()]
