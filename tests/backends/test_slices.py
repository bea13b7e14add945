"""Slices of time: the same bits, checks and end as without slices; and Ctrl-C is handled after one slice."""

import signal
import time
from collections.abc import Callable, Iterator
from typing import Any

import numpy as np
import pytest

from cnnsim import library
from cnnsim.backends import slices
from cnnsim.backends.base import Backend, Outcome
from cnnsim.support.progress import watched_by
from cnnsim.task import Task, make_task
from tests.kits.backends import COMPILING, build, variants

SHAPE = (40, 100)
TASKS: dict[str, tuple[str, dict[str, Any]]] = {
    "sleeping": ("hole-filler", {"limit": 20.0}),
    "dense": ("hole-filler", {"limit": 20.0, "without": ["sleep"]}),
    "fixed": ("hole-filler", {"duration": 3.7}),
    "masked": ("hole-filler", {"mask": np.eye(*SHAPE), "limit": 9.0}),
    "stages": ("diffusion", {"duration": 2.0, "scheme": "rk4"}),
    "stages to rest": ("hole-filler", {"scheme": "heun", "limit": 12.0}),
    "terms": ("median", {"duration": 1.5}),
    "terms by stages": ("median", {"duration": 0.6, "scheme": "rk4"}),
    "discrete time": ("discrete-hole-filler", {"limit": 20.0}),
    "closed form": ("edge", {"duration": 1.5}),
    "closed form at rest": ("edge", {}),
}


@pytest.fixture(
    scope="module", params=[v for v in variants() if v.dtype == "float32" or v.name == "reference"], ids=str
)
def backend(request: pytest.FixtureRequest) -> Backend:
    """In one dtype: slices know nothing of dtypes."""
    return build(*request.param)


def task(name: str, options: dict[str, Any], shape: tuple[int, int] = SHAPE) -> Task:
    picture = np.where(np.random.default_rng(3).random(shape) < 0.4, 1.0, -1.0)
    entry = library.load(name)
    return make_task(entry.network, **{**entry.task(picture), **options})


@pytest.fixture
def short(monkeypatch: pytest.MonkeyPatch) -> Callable[[float, float], None]:
    def cut(first: float, piece: float) -> None:
        for name, value in {"FIRST": first, "SLICE": 1e-9, "PIECE": piece}.items():
            monkeypatch.setattr(slices, name, value)
        monkeypatch.setattr("cnnsim.backends.cpu.tiles.term_tiles.PIECE", piece)

    return cut


@pytest.mark.parametrize("kind", TASKS)
def test_slices_change_no_bit_and_no_check(kind: str, backend: Backend, short: Callable[[float, float], None]) -> None:
    def run() -> tuple[Any, Outcome]:  # with a plan of its own: what is prepared for a plan is kept
        outcome = task(*TASKS[kind]).start(backend)
        return backend.read(outcome.x), outcome

    whole, end = run()
    for first, piece in ((1, 30_000), (100_000, 2**28)):
        short(first, piece)
        cut, other = run()
        np.testing.assert_array_equal(cut, whole)
        assert (other.t, other.settled) == (end.t, end.settled)
        np.testing.assert_equal(other.rate, end.rate)


@pytest.fixture
def alarm() -> Iterator[Callable[[float], None]]:
    """Press Ctrl-C after some seconds."""
    before = signal.signal(signal.SIGALRM, signal.default_int_handler)
    yield lambda seconds: signal.setitimer(signal.ITIMER_REAL, seconds) and None
    signal.setitimer(signal.ITIMER_REAL, 0)
    signal.signal(signal.SIGALRM, before)


ENDLESS: dict[str, tuple[str, dict[str, Any]]] = {
    "fixed": ("hole-filler", {"duration": 1e6}),
    "dense": (
        "diffusion",
        {"duration": "settled", "limit": 1e6, "step": 1e-4, "scheme": "euler", "without": ["sleep"]},
    ),
    "sleeping": ("diffusion", {"duration": "settled", "limit": 1e6, "step": 1e-4, "scheme": "euler"}),
    "stages": ("diffusion", {"duration": 1e6, "scheme": "rk4"}),
    "masked": ("hole-filler", {"mask": np.eye(*SHAPE), "duration": 1e6}),
    "terms": ("median", {"duration": 1e6}),
}


@pytest.mark.skipif(not hasattr(signal, "setitimer"), reason="this system has no timer signals")
@pytest.mark.parametrize("kind", ENDLESS)
def test_a_stop_is_heard_within_a_second(kind: str, backend: Backend, alarm: Callable[[float], None]) -> None:
    if backend.name in COMPILING and kind not in ("dense", "stages", "terms"):
        pytest.skip("each kind builds kernels of its own; these have the loops of all")
    name, options = ENDLESS[kind]
    task(name, {**options, "limit" if "limit" in options else "duration": 0.2}).start(backend)  # compiled
    endless, pause = task(name, options), 0.15
    since = time.monotonic()
    alarm(pause)
    with pytest.raises(KeyboardInterrupt):
        endless.start(backend)
    assert time.monotonic() - since < pause + 1.0
    again = task(name, {**options, "duration": 0.2}).start(backend)  # and nothing is broken
    assert np.isfinite(backend.read(again.x)).all()


class Told:
    def __init__(self) -> None:
        self.shares: list[float | None] = []
        self.texts: list[str] = []
        self.ended = 0

    def __call__(self, share: float | None, text: str) -> None:
        self.shares.append(share)
        self.texts.append(text)

    def over(self) -> None:
        self.ended += 1


@pytest.mark.parametrize("kind", ["sleeping", "dense", "fixed", "terms", "stages to rest"])
def test_who_watches_is_told_how_far_it_is(kind: str, backend: Backend, short: Callable[[float, float], None]) -> None:
    short(50_000, 2**28)
    told = Told()
    with watched_by(told):
        task(*TASKS[kind]).start(backend)
    assert told.shares
    assert told.ended
    if kind in ("fixed", "terms"):
        shares = [share for share in told.shares if share is not None]
        assert shares == sorted(shares)
        assert 0 < shares[0] <= shares[-1] <= 1
    else:
        assert set(told.shares) == {None}
        assert any("|dx/dt|" in text and "become 0.0001" in text for text in told.texts)


def test_pieces_are_dealt_out_without_a_remainder() -> None:
    found = slices.pieces(23, slices.PIECE / 5.5, workers=4)
    assert found == [(first, min(first + 4, 23)) for first in range(0, 23, 4)]
    assert slices.pieces(5, 2.0 * slices.PIECE, workers=2) == [(0, 2), (2, 4), (4, 5)]
    assert slices.pieces(5, slices.PIECE / 5, workers=2) == ((0, 5),)
