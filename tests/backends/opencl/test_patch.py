"""Patches of cells in registers (kernels/patch.cl): a grid in one group, tiles, shuffles; the ends of the reference."""

from typing import Any

import numpy as np
import pytest

from cnnsim import PERIODIC, ZERO_FLUX, Template, fixed, library
from cnnsim.backends import get, slices
from cnnsim.backends.opencl import patch_steps
from cnnsim.backends.opencl.patch_steps import Patch
from cnnsim.task import make_task
from tests.kits.opencl import OpenCLBackend, counted

NINE = np.arange(1, 10).reshape(3, 3) * 0.03 * np.array([[1, -1, 1], [-1, 1, 1], [1, 1, -1]])
SHAPES = [(7, 9), (40, 53), (2, 13, 30)]
SHUFFLED = Patch(8, 4, 8, 4, shuffles=2)


def assert_ends_alike(task: Any, backend: OpenCLBackend, most: float) -> None:
    law = get("reference")
    found, wanted = task.start(backend), task.start(law)
    assert (found.t, found.settled) == (wanted.t, wanted.settled)
    assert np.abs(backend.read(found.x) - law.read(wanted.x)).max() <= most
    np.testing.assert_allclose(found.rate, wanted.rate, rtol=1e-4 if most else 1e-12)


@pytest.mark.parametrize("boundary", [ZERO_FLUX, PERIODIC, fixed(0.5, -0.3)], ids=str)
def test_shuffled_patches_end_as_on_the_reference(boundary: Any, monkeypatch: pytest.MonkeyPatch) -> None:
    """The exchange by shuffles of NVIDIA, replaced by one through local memory."""
    monkeypatch.setattr(patch_steps, "TEST_PATCH", SHUFFLED)
    backend, rng = OpenCLBackend("float32", family="gpu"), np.random.default_rng(1)
    for shape in SHAPES[1:2] if boundary is PERIODIC else SHAPES:  # a torus in one tile has no shuffles
        task = make_task(
            Template(NINE), state=rng.uniform(-1.5, 1.5, shape), boundary=boundary, scheme="euler", step=0.1, limit=30.0
        )
        assert_ends_alike(task, backend, 1e-6)


@pytest.mark.parametrize("shape", SHAPES, ids=str)
def test_slices_within_a_time_constant_change_nothing(shape: tuple[int, ...], monkeypatch: pytest.MonkeyPatch) -> None:
    """In float64 the bits and times of the reference, however the steps are cut into launches."""
    backend, x = OpenCLBackend("float64", family="gpu"), np.random.default_rng(2).uniform(-1.5, 1.5, shape)
    for first, limit in ((1 << 24, 30.0), (3000, 30.0), (1 << 24, 3.0), (3000, 3.0), (1, 0.0)):
        monkeypatch.setattr(slices, "FIRST", first)
        task = make_task(Template(NINE), state=x, boundary=ZERO_FLUX, scheme="euler", step=0.1, limit=limit)
        assert_ends_alike(task, backend, 0.0)


def test_a_grid_in_one_group_settles_in_one_launch_and_a_batch_in_two() -> None:
    """The drive of the input, the launch, and the search for numbers that are not finite; the words of the checks."""
    entry, rng = library.load("hole-filler"), np.random.default_rng(1)
    backend = OpenCLBackend("float32", family="gpu")
    for shape, launches in (((8, 8), 4), ((5, 8, 8), 5)):
        picture = np.where(rng.random(shape) < 0.4, 1.0, -1.0)
        task = make_task(entry.network, **entry.task(picture))
        counts = counted(backend, lambda task=task: task.start(backend))  # type: ignore[misc]
        assert (counts.launches, counts.waits) == (launches, 2)


def test_the_host_waits_once_in_sixteen_checks_of_a_large_grid(monkeypatch: pytest.MonkeyPatch) -> None:
    for name, value in {"FIRST": 1 << 40, "SLICE": 1e3}.items():  # no wait for signals
        monkeypatch.setattr(slices, name, value)
    picture = np.where(np.random.default_rng(1).random((40, 53)) < 0.4, 1.0, -1.0)
    entry, backend = library.load("hole-filler"), OpenCLBackend("float32", family="gpu")
    task = make_task(entry.network, **entry.task(picture))
    counts = counted(backend, lambda: task.start(backend))
    checks = task.start(backend).t
    assert counts.waits == 1 + -(-(checks + 1) // 16)
    assert counts.launches == 2 + (counts.waits - 1) * (1 + 16 * 3), "three launches of up to four steps a check"
