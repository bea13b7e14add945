"""Cells in discrete time: batches that settle one after the other, cycles, and the sigmoid."""

import numpy as np
import pytest

from cnnsim import Cell, InputError, Template, run, run_transient
from cnnsim.backends.base import Backend
from cnnsim.network import Characteristic
from tests.kits.backends import REFERENCE


def test_a_batch_is_done_when_its_last_grid_is(backend: Backend) -> None:
    picture = np.where(np.random.default_rng(5).random((2, 9, 11)) < 0.6, 1.0, -1.0)
    law = [run("discrete-hole-filler", grid, backend=REFERENCE) for grid in picture]
    ours = run("discrete-hole-filler", picture, backend=backend)
    assert np.array_equal(ours.y, np.stack([result.y for result in law]))
    assert ours.t == max(result.t for result in law)
    with pytest.raises(InputError, match="has not settled"):
        run_transient(Template([[-1.0]]), state=picture, cell="discrete-time", backend=backend)


def test_the_sigmoid_in_this_precision(backend: Backend) -> None:
    u = np.linspace(-1, 1, 4001).reshape(1, -1)
    found = run_transient(
        Template(0, [[16.0]]), state=np.zeros(u.shape), input=u, duration=1.0,
        cell=Cell("discrete-time", Characteristic("tanh")), backend=backend,
    ).y  # fmt: skip
    exact = np.tanh((16 * u.astype(backend.dtype)).astype(np.float64))
    assert np.abs(found - exact).max() <= {"float32": 2e-7, "float64": 1e-15}[backend.dtype.name]
    assert np.abs(found).max() <= 1
