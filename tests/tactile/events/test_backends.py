"""Events are the same on every backend, on a scene and on a recording that nobody here made."""

from functools import cache
from itertools import islice

import pytest

from tactile.core.frame import Frame
from tactile.core.source import FrameStream
from tactile.events.event import EventLog
from tactile.pipeline import run
from tactile.settings import Settings
from tactile.sources import open_source
from tests.kits.paths import DATA
from tests.kits.serial import GRIP

OTHERS = ["reference", "opencl"]
GRASP = DATA / "papillarray" / "grasp_release_0degree_0offset_22-00-10.npz"


@cache
def told(backend: str, recorded: bool) -> list[tuple[object, ...]]:
    """What is told of every event on a backend, in the grip's first 1.8 s or a real grasp."""
    source = open_source(GRASP if recorded else GRIP)
    frames: list[Frame] = list(islice(source, 3000 if recorded else 2 * 360))
    log = EventLog()
    stream = FrameStream("", source.arrays, source.modulus, len(frames), frames)
    settings = Settings(tare="auto" if recorded else "off", backend=backend)
    run(stream, settings, [lambda report: log.add(report.events, report.ended)])
    return [(e.finger, e.kind, e.t, e.end, e.told, e.taxels, e.words, e.arrows, e.ternary, e.hand) for e in log.events]


def skip_without(backend: str) -> None:
    if backend == "opencl":
        pytest.importorskip("pyopencl")


@pytest.mark.parametrize("backend", OTHERS)
def test_a_scene_is_told_alike(backend: str) -> None:
    skip_without(backend)
    assert told(backend, False) == told("cpu", False)
    assert len(told("cpu", False)) >= 8


@pytest.mark.skipif(not GRASP.exists(), reason="the recordings lie beside the project, and are not here")
@pytest.mark.parametrize("backend", OTHERS)
def test_a_recording_is_told_alike(backend: str) -> None:
    skip_without(backend)
    assert told(backend, True) == told("cpu", True)
    assert len(told("cpu", True)) >= 6
