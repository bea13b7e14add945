"""Sleeping tiles of the OpenCL backend: the same bits as without, in tiles of all sizes, left out where they may be."""

from typing import Any

import numpy as np
import pyopencl as cl
import pytest

from cnnsim import PERIODIC, ZERO_FLUX, Template, fixed, library
from cnnsim.task import make_task
from tests.kits.opencl import FAMILIES, Family, OpenCLBackend


@pytest.mark.parametrize("family", FAMILIES)
@pytest.mark.parametrize("boundary", [fixed(-1.0), ZERO_FLUX, PERIODIC], ids=str)
@pytest.mark.parametrize("name", ["hole-filler", "connected-components-horizontal"])
def test_sleeping_tiles_wake_up_where_a_wave_comes(name: str, boundary: Any, family: Family) -> None:
    """Two grids at once, three tiles beside each other, the last of them narrow; one grid settles much earlier.

    On a CPU the kernels of GPUs take twenty times as long, and are followed for a part of the way.
    """
    picture = np.where(np.random.default_rng(8).random((2, 150, 265)) > 0.93, 1.0, -1.0)
    picture[0, 40:110, [60, 160]] = picture[0, [40, 110], 60:160] = 1
    picture[1, :, 20:] = -1
    entry, backend = library.load(name), OpenCLBackend("float32", family=family)
    planes: dict[str, Any] = {
        name: np.broadcast_to(plane, picture.shape) for name, plane in entry.planes(picture).items()
    }
    ends, limit = [], 300.0 if family == "cpu" else 100.0
    for without in ([], ["sleep"]):
        end = make_task(entry.template, **planes, boundary=boundary, limit=limit, without=without).start(backend)
        ends.append((backend.read(end.x), end.t, end.settled, end.rate))
    np.testing.assert_array_equal(ends[0][0], ends[1][0])
    np.testing.assert_equal(ends[0][1:], ends[1][1:])


@pytest.mark.parametrize("family", FAMILIES)
def test_masked_tiles_that_read_far_sleep_and_wake_up(family: Family) -> None:
    """A wave that begins in a corner of a torus and goes two cells at a time; the last tiles are narrow."""
    A, rng, shape = np.zeros((5, 5)), np.random.default_rng(5), (2, 109, 141)
    A[2, 2], A[[0, 2, 2, 4], [2, 0, 4, 2]] = 3, 1
    x = np.ones(shape)
    x[0, :4, :4] = -1
    given: Any = {
        "state": x, "input": np.where(rng.random(shape) > 0.9, 1.0, -1.0), "mask": rng.uniform(-1, 0.05, shape),
        "boundary": PERIODIC, "scheme": "euler", "limit": 300.0,
    }  # fmt: skip
    ends, backend = [], OpenCLBackend("float64", family=family)
    for without in ([], ["sleep"]):
        task = make_task(Template(A, [[4.0]], -1.0), **given, without=without)
        assert ("sleep" in task.plan.savings) == (not without)
        end = task.start(backend)
        ends.append((backend.read(end.x), end.t, end.settled, end.rate))
    np.testing.assert_array_equal(ends[0][0], ends[1][0])
    np.testing.assert_equal(ends[0][1:], ends[1][1:])
    assert ends[0][2] and np.mean(ends[0][0][0] < 0) > 0.2


@pytest.mark.parametrize("family", FAMILIES)
def test_a_tile_coasts_while_no_output_in_it_can_change_and_then_sleeps(
    family: Family, monkeypatch: pytest.MonkeyPatch
) -> None:
    from cnnsim.backends.opencl import tile_steps

    entry, backend, seen = library.load("hole-filler"), OpenCLBackend("float32", family=family), list[Any]()
    steps = tile_steps.TileSteps.advance

    def advance(self: Any, step: int, count: int) -> None:
        steps(self, step, count)
        found = np.empty(self._tiles.number, np.uint8)
        cl.enqueue_copy(self._context.queue, found, self._moved[self._state.turn - 1])
        seen.append(found)

    monkeypatch.setattr(tile_steps.TileSteps, "advance", advance)
    monkeypatch.setattr(tile_steps, "MANY", 1000)  # what is found is that of the steps asked for, of none ahead
    monkeypatch.setattr(tile_steps, "ROUNDS", 1)
    picture = np.full((2, 150, 265), -1.0)
    picture[0] = 1  # nothing can change in this grid, and in the other a wave goes through all
    planes: dict[str, Any] = {k: np.broadcast_to(plane, picture.shape) for k, plane in entry.planes(picture).items()}
    make_task(entry.template, **planes, boundary=fixed(-1.0), limit=40.0).start(backend)
    flags = np.array(seen).reshape(len(seen), 2, -1)
    assert (flags[:, 0] <= 1).all() and (flags[:5, 0] == 1).all(), "it coasts: its states still change"
    assert (flags[-1, 0] == 0).all(), "it sleeps"
    assert (flags[-1, 1] > 1).any(), "the other one is awake"


@pytest.mark.parametrize("boundary", [fixed(-1.0), ZERO_FLUX, PERIODIC], ids=str)
def test_tiles_are_cut_smaller_and_larger_again_and_go_by_rounds_with_the_same_bits(
    boundary: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    """At every other look, with a mask; the stacks of the smaller tiles are not all full, the last ones are narrow."""
    from cnnsim.backends.opencl import tile_steps, tiles

    changes, taken, cut = list[bool](), _rounds_taken(monkeypatch), tiles.cut

    def noted(*given: Any, light: bool) -> Any:
        changes.append(light)
        return cut(*given, light=light)

    monkeypatch.setattr(tile_steps, "cut", noted)
    monkeypatch.setattr(tiles, "NAP", 5)  # two rounds a check
    wayward = {"LOOK": 4, "LEAST_LIGHT": 0, "ROUNDS": 7, "FEW_RESTLESS": 2.0, "MOST_RESTLESS": -1.0}
    for name, value in wayward.items():
        monkeypatch.setattr(tile_steps, name, value)
    entry, backend, rng = library.load("hole-filler"), OpenCLBackend("float32", family="cpu"), np.random.default_rng(8)
    picture = np.where(rng.random((2, 150, 265)) > 0.93, 1.0, -1.0)
    planes: dict[str, Any] = {k: np.array(np.broadcast_to(p, picture.shape)) for k, p in entry.planes(picture).items()}
    planes["state"][:, :6, :6] = -1  # where a wave begins, also with nothing around the grid
    mask, ends = rng.uniform(-1, 0.01, picture.shape), []
    for without in ([], ["sleep"]):
        end = make_task(entry.template, **planes, mask=mask, boundary=boundary, limit=60.0, without=without)
        x, *others = end.start(backend)
        ends.append((backend.read(x), others))
    np.testing.assert_array_equal(ends[0][0], ends[1][0])
    np.testing.assert_equal(ends[0][1], ends[1][1])
    assert changes[:4] == [False, True, False, True]
    assert {6} < {asked for asked, _ in taken}, "three checks, of two rounds each"


@pytest.mark.parametrize(("items", "patience"), [(2, 1 << 14), (2, 1), (7, 1), (7, 1 << 14)])
@pytest.mark.parametrize("boundary", [fixed(-1.0), PERIODIC], ids=str)
def test_no_round_begins_after_one_in_which_nothing_moves(
    boundary: Any, items: int, patience: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    """In whatever order work-items come: more than there are threads, and such as leave all to the others at once."""
    from cnnsim.backends.opencl import tile_steps

    entry, backend, rng = library.load("hole-filler"), OpenCLBackend("float32", family="cpu"), np.random.default_rng(8)
    monkeypatch.setattr(tile_steps, "PATIENCE", patience)
    monkeypatch.setattr(backend._context, "cores", items)
    taken = _rounds_taken(monkeypatch)
    picture = np.where(rng.random((2, 150, 265)) > 0.93, 1.0, -1.0)
    planes: dict[str, Any] = {k: np.array(np.broadcast_to(p, picture.shape)) for k, p in entry.planes(picture).items()}
    planes["state"][:, :6, :6] = -1
    ends = []
    for without in ([], ["sleep"]):
        x, *others = make_task(entry.template, **planes, boundary=boundary, limit=300.0, without=without).start(backend)
        ends.append((backend.read(x), others))
    np.testing.assert_array_equal(ends[0][0], ends[1][0])
    assert ends[0][1] == ends[1][1] and ends[0][1][1], "settled, at the same time"
    assert any(0 < went_on < asked for asked, went_on in taken)
    assert sum(went_on for asked, went_on in taken if asked > 1) > 50


def _rounds_taken(monkeypatch: pytest.MonkeyPatch) -> list[tuple[int, int]]:
    """Return what will have, for each launch, how many rounds were asked for and how many count."""
    from cnnsim.backends.opencl import tile_steps

    asked, taken = list[int](), list[tuple[int, int]]()
    launch, go_on = tile_steps.TileSteps._launch, tile_steps.TileSteps._go_on

    def launched(self: Any, state: Any, now: int, rounds: int, each: int) -> None:
        asked.append(rounds)
        launch(self, state, now, rounds, each)

    def gone_on(self: Any, step: int, count: int) -> None:
        go_on(self, step, count)
        taken.append((asked[-1], len(self._ahead)))

    monkeypatch.setattr(tile_steps.TileSteps, "_launch", launched)
    monkeypatch.setattr(tile_steps.TileSteps, "_go_on", gone_on)
    return taken


@pytest.mark.parametrize("family", FAMILIES)
@pytest.mark.parametrize("limit", [20.0, 20.125, 20.375])
def test_what_goes_ahead_of_a_check_ends_at_the_limit(
    limit: float, family: Family, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Launches of four steps fill a time constant of eight, and the limit leaves none, one or three of them."""
    from cnnsim.backends.opencl import tile_steps

    monkeypatch.setattr(tile_steps, "MANY", 1)
    entry, backend = library.load("hole-filler"), OpenCLBackend("float32", family=family)
    planes: dict[str, Any] = entry.planes(np.where(np.random.default_rng(8).random((150, 265)) > 0.93, 1.0, -1.0))
    ends = []
    for without in ([], ["sleep"]):
        task = make_task(
            entry.template, **planes, boundary=fixed(-1.0), scheme="euler", step=0.125, limit=limit, without=without
        )
        end = task.start(backend)
        ends.append((backend.read(end.x), end.t, end.settled, end.rate))
    np.testing.assert_array_equal(ends[0][0], ends[1][0])
    np.testing.assert_equal(ends[0][1:], ends[1][1:])
