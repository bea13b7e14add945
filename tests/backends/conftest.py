"""The fixture `backend`: every backend in turn. One that stands in `cnnsim.backends.NAMES` is one of them."""

import pytest

from cnnsim.backends.base import Backend
from tests.kits.backends import TOLERANCE, build, variants


@pytest.fixture(scope="session", params=variants(), ids=str)
def backend(request: pytest.FixtureRequest) -> Backend:
    return build(*request.param)


@pytest.fixture(scope="session")
def tolerance(backend: Backend) -> float:
    return TOLERANCE[backend.dtype.name]
