"""What all tests share."""

import gc
import os
from collections.abc import Iterator
from contextlib import suppress
from typing import Any

import pytest
from hypothesis import HealthCheck, settings

from cnnsim.support.notices import Notices
from tactile.bump import table
from tests.kits.haste import in_haste
from tests.kits.slow import is_slow

os.environ.setdefault("CNNSIM_POCL_PROCESSOR", "auto")  # without it PoCL may build nothing

# How long an example takes says more about the machine, and what it has to compile first, than about the code.
settings.register_profile("any machine", deadline=None, suppress_health_check=[HealthCheck.too_slow])
settings.load_profile("any machine")


@pytest.fixture(scope="session", autouse=True)
def bumps_are_kept_for_the_session_alone(tmp_path_factory: pytest.TempPathFactory) -> Iterator[None]:
    kept = tmp_path_factory.mktemp("bumps")
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(table, "folder", lambda: kept)
        yield


@pytest.fixture(autouse=True)
def notices_are_warnings() -> None:
    """Undo what two commands at the same time, in two threads, leave: each puts back what it found."""
    Notices.tell = None


def pytest_collection_finish() -> None:
    """Leave what is there before the first test, millions of objects, out of all garbage collections, and have few.

    They take a tenth of the time in which numba compiles.
    """
    gc.collect()
    gc.freeze()
    gc.set_threshold(10_000)


_in_haste = [False]


@pytest.fixture(scope="session", autouse=True)
def most_kernels_are_built_in_haste() -> Iterator[None]:
    """Leave out the optimiser of OpenCL programs: see `tests.kits.haste`."""
    with pytest.MonkeyPatch.context() as patch:
        with suppress(ImportError):
            import pyopencl as cl

            build = cl.Program.build

            def built(program: Any, options: list[str], **others: Any) -> Any:
                return build(program, [*options, "-cl-opt-disable"] if _in_haste[0] else options, **others)

            patch.setattr(cl.Program, "build", built)
        yield


def pytest_runtest_setup(item: pytest.Item) -> None:
    _in_haste[0] = in_haste(item.nodeid)


@pytest.hookimpl(tryfirst=True)  # before tests are chosen by their markers
def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """OpenCL first: of two workers one then builds its programs, the other meanwhile compiles the numba kernels.

    Of these first what is optimised: the others leave kernels behind that were built in haste.
    """
    for item in items:
        if is_slow(item.nodeid):
            item.add_marker(pytest.mark.slow)
    items.sort(key=lambda item: ("opencl" not in item.nodeid, in_haste(item.nodeid)))
