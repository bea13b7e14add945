"""One Chromium for all tests of the page, which are skipped where it is absent."""

from collections.abc import Iterator
from functools import partial

import pytest

from cnnsim.studio.session import Session
from cnnsim.studio.setup import first_setup
from tests.kits.browser import Browser, opened
from tests.kits.studio import GRID, serving


@pytest.fixture(scope="package")
def browser(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Browser]:
    pytest.importorskip("starlette", reason="needs the extra studio")
    model = partial(Session, first_setup("hole-filler", (16, 16)))
    with serving(model) as address, opened(address, tmp_path_factory.mktemp("profile")) as one:
        one.until("document.querySelector('#name').textContent", "hole-filler")
        yield one


@pytest.fixture
def no_console_error(browser: Browser) -> Iterator[None]:
    yield
    browser.page.keyboard.press("Escape")  # closes a dialog
    said, browser.console[:] = list(browser.console), []
    assert not said


@pytest.fixture
def session(monkeypatch: pytest.MonkeyPatch) -> Session:
    """A session on a small grid; a frame is waited for, however busy the machine is."""
    monkeypatch.setattr("cnnsim.studio.session.FRAME_SECONDS", 60.0)
    return Session(first_setup("hole-filler", GRID))
