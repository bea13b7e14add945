"""The page of the live array view opens in Chromium and draws; `test_page` looks at everything on it."""

import numpy as np

from tests.kits.browser import Browser


def test_the_page_opens_and_draws_both_fingers(browser: Browser) -> None:
    for finger in (0, 1):
        browser.shows(finger, lambda pixels: len(np.unique(pixels.reshape(-1, 4), axis=0)) > 3, ".finger .box canvas")
    assert "left" in browser.text("body")
    assert browser.console == []
