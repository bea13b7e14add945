"""Events are the same on every backend, on a scene and on a real recording."""

from functools import cache
from itertools import islice

import pytest

from tactile.core.frame import Frame
from tactile.core.source import FrameStream
from tactile.sources import open_source
from tests.kits.paths import DATA
from tests.kits.serial import GRIP
from tests.kits.touch.made import events

OTHERS = ["reference", "opencl"]
GRASP = DATA / "papillarray" / "grasp_release_0degree_0offset_22-00-10.npz"


@cache
def events_of(backend: str, recorded: bool) -> list[tuple[object, ...]]:
    """All fields of every event on a backend, in the first 1.8 s of the grip scene or in a real grasp."""
    source = open_source(GRASP if recorded else GRIP)
    frames: list[Frame] = list(islice(source, 3000 if recorded else 2 * 360))
    stream = FrameStream("", source.arrays, source.modulus, len(frames), frames)
    found = events(stream, tare="auto" if recorded else "off", backend=backend)
    return [(e.finger, e.kind, e.t, e.end, e.told, e.taxels, e.words, e.arrows, e.ternary, e.hand) for e in found]


def skip_without(backend: str) -> None:
    if backend == "opencl":
        pytest.importorskip("pyopencl")


@pytest.mark.parametrize("backend", OTHERS)
def test_a_scene_has_the_same_events(backend: str) -> None:
    skip_without(backend)
    assert events_of(backend, False) == events_of("cpu", False)
    assert len(events_of("cpu", False)) >= 8


@pytest.mark.skipif(not GRASP.exists(), reason="the papillarray recordings are not available")
@pytest.mark.parametrize("backend", OTHERS)
def test_a_recording_has_the_same_events(backend: str) -> None:
    skip_without(backend)
    assert events_of(backend, True) == events_of("cpu", True)
    assert len(events_of("cpu", True)) >= 6
