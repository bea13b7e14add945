"""What all tests share."""

from collections.abc import Iterator

import pytest

from tactile.bump import table


@pytest.fixture(scope="session", autouse=True)
def bumps_are_kept_for_the_session_alone(tmp_path_factory: pytest.TempPathFactory) -> Iterator[None]:
    kept = tmp_path_factory.mktemp("bumps")
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(table, "folder", lambda: kept)
        yield
