"""The page of the playground opens in Chromium and draws; `test_page` clicks through all of it."""

import numpy as np

from tests.kits.browser import EMPTY, LEFT, Browser


def test_the_page_opens_and_a_line_is_drawn(browser: Browser) -> None:
    browser.open(EMPTY)
    browser.drag(LEFT, (4, 4), (4, 10))
    browser.shows(LEFT, lambda pixels: len(np.unique(pixels.reshape(-1, 4), axis=0)) > 1)
    assert browser.text("#name") == "hole-filler"
    assert browser.console == []
