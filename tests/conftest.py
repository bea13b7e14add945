"""What all tests share."""

import os
from collections.abc import Iterator

import pytest
from hypothesis import HealthCheck, settings

from tactile.bump import table

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


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """OpenCL first: of two workers one then builds its programs, the other meanwhile compiles the numba kernels.

    Of these first the backend's own: the others leave kernels behind that were built in haste, which are slow.
    """
    items.sort(key=lambda item: ("opencl" not in item.nodeid, "backends/opencl/" not in item.nodeid))
