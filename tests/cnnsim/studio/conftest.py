"""One Chromium for all tests of the page, which are skipped where it is absent."""

import shutil
from collections.abc import Iterator

import pytest

from cnnsim.studio.session import Session
from cnnsim.studio.setup import first_setup
from tests.kits.browser import Browser
from tests.kits.studio import FLAGS, GRID, serving

CHROMIUM = shutil.which("chromium") or shutil.which("chromium-browser")


@pytest.fixture(scope="package")
def browser(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Browser]:
    sync_api = pytest.importorskip("playwright.sync_api", reason="needs playwright")
    pytest.importorskip("starlette", reason="needs the extra studio")
    if CHROMIUM is None:
        pytest.skip("needs Chromium: apt-get install chromium")
    with serving(lambda: Session(first_setup("hole-filler", (16, 16)))) as address, sync_api.sync_playwright() as play:
        folder = tmp_path_factory.mktemp("profile")
        context = play.chromium.launch_persistent_context(
            folder, executable_path=CHROMIUM, args=FLAGS, viewport={"width": 1024, "height": 700}, color_scheme="light"
        )
        context.set_default_timeout(8000)
        one = Browser(context.pages[0], address)
        one.page.goto(address)
        one.until("document.querySelector('#name').textContent", "hole-filler")
        yield one
        context.close()


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
