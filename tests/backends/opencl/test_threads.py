"""Threads that share the OpenCL backend do not get into each other's kernels."""

import sys
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from cnnsim import Template, run_transient
from tests.kits.opencl import FAMILIES, Family, OpenCLBackend

TEMPLATE = Template([[0, 0.3, 0], [0.2, 1.5, -0.4], [0, 0.1, 0]], 0, 0.1)


@pytest.fixture
def eager_threads() -> Iterator[None]:
    """Let threads take turns a thousand times as often as they do."""
    usual = sys.getswitchinterval()
    sys.setswitchinterval(1e-6)
    yield
    sys.setswitchinterval(usual)


@pytest.mark.usefixtures("eager_threads")
@pytest.mark.parametrize("family", FAMILIES)
def test_four_threads_get_what_one_gets(family: Family) -> None:
    backend = OpenCLBackend(family=family)

    def ends(state: NDArray[Any], times: int = 50) -> list[NDArray[Any]]:
        return [run_transient(TEMPLATE, state=state, duration=1.0, backend=backend).x for _ in range(times)]

    states = [np.full((40, 40), value) for value in (-0.9, -0.3, 0.3, 0.9)]
    alone = [ends(state, 1) for state in states]
    with ThreadPoolExecutor(4) as threads:
        together = list(threads.map(ends, states))
    np.testing.assert_array_equal(np.array(together), np.repeat(alone, 50, axis=1))
