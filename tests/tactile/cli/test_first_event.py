"""The first event of a live run: nothing is compiled or imported after the warm-up."""

import json
import subprocess

from tests.kits.processes import code_line

RUN = """
import json, sys, time
from dataclasses import replace
import numpy as np
from numba.core.dispatcher import Dispatcher
from tactile import pipeline
from tactile.cli.port.live import LiveMonitor
from tactile.live_options import LiveOptions
from tactile.core.source import FrameStream
from tactile.simulator.scene_file.file import read_scene
from tactile.wire.packets import emulated_description
from tactile.wire.source import WireSource
from tests.kits.serial import GRIP, grip

late = []
plain = Dispatcher.compile
Dispatcher.compile = lambda self, signature: (late.append(self.py_func.__name__), plain(self, signature))[1]
scene = grip(3.0)
source = WireSource(emulated_description("native", scene), ())
for quantity in ("strain", "stress", "force"):
    arrays = tuple(replace(array, quantity=quantity) for array in scene.arrays)
    found = list(replace(read_scene(GRIP), arrays=scene.arrays if quantity == "force" else arrays))
    largest = max(np.abs(frame.values).max() for frame in found)
    scale = -1e3 if quantity == "force" else 1.0  # a point load presses one force taxel alone: strains as forces
    rng = np.random.default_rng(0)
    frames = []
    for frame in found:
        values = scale * (frame.values + 3e-4 * largest * rng.standard_normal(frame.values.shape))
        if 1.2 < frame.t < 1.25:
            values[0, 0] *= -3.0  # a taxel that contradicts the others
        frames.append(replace(frame, values=values))
    options = LiveOptions(tare="auto")
    modulus = None if quantity == "force" else scene.modulus
    source.arrays = arrays
    settings = options.settings(source)
    pipeline.warm_up(arrays, modulus, settings)
    late.clear()
    before, output, spent = set(sys.modules), [], []
    monitor = LiveMonitor(source, lambda line: output.append(json.dumps(line)))
    since = [time.thread_time()]

    def sink(report):
        monitor(report)
        now = time.thread_time()
        if report.events:
            spent.append(now - since[0])
        since[0] = time.thread_time()

    pipeline.run(FrameStream("grip", arrays, modulus, len(frames), frames), settings, [sink])
    kinds = sorted({json.loads(line)["kind"] for line in output if '"kind"' in line})
    print(json.dumps({"late": late, "imported": sorted(set(sys.modules) - before), "kinds": kinds,
                      "first_ms": 1e3 * spent[0]}))
"""


def test_nothing_is_compiled_or_imported_after_the_warm_up() -> None:
    """For strain, stress and force; the first event takes at most 5 ms of processor time."""
    done = subprocess.run(code_line(RUN), capture_output=True, text=True, timeout=280)
    assert done.returncode == 0, done.stderr
    for line in done.stdout.splitlines():
        result = json.loads(line)
        assert result["late"] == []
        assert result["imported"] == []
        assert {"contact", "load", "hold", "tangential_load", "release"} <= set(result["kinds"])
        assert result["first_ms"] <= 5.0
    assert len(done.stdout.splitlines()) == 3
