"""The picture of the playground in Chromium: drawing, steps, weights and rules by clicks, keys and pixels."""

import time

import numpy as np
import pytest

from tests.kits.browser import EMPTY, LEFT, RIGHT, Browser

pytestmark = [pytest.mark.slow, pytest.mark.usefixtures("no_console_error")]


def test_a_drawn_ring_is_filled_by_the_wave(browser: Browser) -> None:
    browser.open(EMPTY)
    browser.page.fill("[name=brush]", "1")
    browser.page.uncheck("[name=rest]")
    browser.page.select_option("[name=speed]", "10")
    browser.page.click("[name=play]")
    browser.until("Number(document.querySelector('[name=scrub]').value) > 150")  # all is white, and it still runs
    browser.page.check("[name=rest]")
    browser.drag(LEFT, (4, 4), (4, 10), (10, 10), (10, 4), (4, 4))
    browser.until("document.querySelector('.cw-status').textContent.startsWith('at rest')")
    ring = browser.pixels(LEFT)[..., 0] == 0
    assert ring[4, 4:11].all()
    assert ring.sum() == 24
    browser.page.click("[name=y]")
    browser.until("document.querySelector('[name=y]').getAttribute('aria-pressed')", "true")
    filled = np.zeros((16, 16), bool)
    filled[4:11, 4:11] = True
    browser.shows(RIGHT, lambda colours: np.array_equal(colours[..., 0] == 0, filled))
    browser.page.click("[name=x]")
    browser.page.check("[data-ink=erase]")
    browser.drag(LEFT, (4, 6), (4, 8))
    browser.until("document.querySelector('.cw-status').textContent.startsWith('at rest')")
    assert (browser.pixels(LEFT)[4, 6:9, 0] == 255).all()
    browser.page.check("[data-ink=black]")


def test_the_state_shows_what_is_beyond_1_in_other_colours(browser: Browser) -> None:
    browser.open(EMPTY)
    colours = browser.pixels(RIGHT)
    assert (colours[..., 0] == colours[..., 2]).all()  # x(0) = 1 is black
    browser.rest()
    browser.shows(RIGHT, lambda colours: (colours[..., 2] - colours[..., 0] > 50).all())  # far below -1: blue


def test_steps_back_and_scrubbing_show_the_same_pictures(browser: Browser) -> None:
    browser.open("template=hole-filler&size=16x16&picture=curves&seed=1")
    seen = []
    for number in range(1, 5):
        browser.page.click("[name=next]")
        browser.until("document.querySelector('[name=clock]').textContent", f"t = {number / 10:.2f}")
        seen.append(browser.pixels(RIGHT))
    assert not np.array_equal(seen[0], seen[3])
    browser.page.click("[name=previous]")
    browser.until("document.querySelector('[name=clock]').textContent", "t = 0.30")
    assert np.array_equal(browser.pixels(RIGHT), seen[2])
    browser.page.fill("[name=scrub]", "1")
    browser.until("document.querySelector('[name=clock]').textContent", "t = 0.10")
    assert np.array_equal(browser.pixels(RIGHT), seen[0])
    browser.page.locator(".cw-pane canvas").nth(RIGHT).focus()
    browser.page.keyboard.press(".")
    browser.until("document.querySelector('[name=clock]').textContent", "t = 0.20")
    assert np.array_equal(browser.pixels(RIGHT), seen[1])


def test_weights_are_typed_turned_and_dragged_with_their_twins(browser: Browser) -> None:
    browser.open(EMPTY)
    browser.page.click("#tab-weights")
    field = "[aria-label='A, neighbour (-1, 0)']"
    twin = "[aria-label='A, neighbour (0, 1)']"
    browser.page.fill(field, "1.5")
    browser.until("document.querySelector('#name').textContent", "hole-filler (changed)")
    assert browser.page.input_value(twin) == "1.5"
    browser.page.hover(twin)
    browser.page.mouse.wheel(0, -1)
    browser.until(f'document.querySelector("{field}").value', "1.6")
    browser.page.select_option("[name=lock]", "none")
    browser.page.focus(twin)
    browser.page.keyboard.press("ArrowDown")
    browser.until(f'document.querySelector("{twin}").value', "1.5")
    assert browser.page.input_value(field) == "1.6"
    box = browser.page.locator("[aria-label='z, bias']").bounding_box()
    browser.page.mouse.move(box["x"] + 20, box["y"] + 15)
    browser.page.mouse.down()
    browser.page.mouse.move(box["x"] + 20, box["y"] - 25, steps=4)
    browser.page.mouse.up()
    browser.until("Number(document.querySelector(\"[aria-label='z, bias']\").value) > -0.5")
    browser.page.click("[name=reset]")
    browser.until("document.querySelector('#name').textContent", "hole-filler")
    browser.page.select_option("[name=lock]", "full")


def test_a_change_while_it_runs_is_seen(browser: Browser) -> None:
    browser.open(EMPTY)
    browser.page.uncheck("[name=rest]")
    browser.page.click("[name=play]")
    browser.until("Number(document.querySelector('[name=scrub]').value) > 20")
    browser.page.fill("[aria-label='z, bias']", "14")  # now black wins everywhere
    browser.orange()
    assert "Pause" in browser.text("[name=play]")
    assert browser.text("[name=clock]").endswith(", past gone")  # the scrub begins at the change
    browser.page.check("[name=rest]")


def test_a_change_at_rest_or_in_between_shows_its_effect(browser: Browser) -> None:
    browser.open(EMPTY)
    browser.rest()
    browser.page.fill("[aria-label='z, bias']", "8")  # it plays again
    browser.orange()
    browser.stop()
    for _ in range(5):
        browser.page.click("[name=next]")
    browser.until("document.querySelector('[name=clock]').textContent", "t = 0.50")
    before = browser.pixels(RIGHT)
    browser.page.fill("[aria-label='z, bias']", "-4")
    browser.until("location.hash.includes('weights=')")
    end = time.monotonic() + 20
    while np.array_equal(browser.pixels(RIGHT), before):
        assert time.monotonic() < end
    assert browser.text("[name=clock]") == "t = 0.50"  # the same time with other numbers


def test_rules_change_boundary_cell_scheme_step_accuracy_and_backend(browser: Browser) -> None:
    browser.open(EMPTY)
    browser.page.click("#tab-run")
    browser.page.select_option("[name=scheme]", "rk4")
    browser.until("document.querySelector('.plan').textContent.includes('rk4')")
    browser.page.fill("[name=step]", "0.05")
    browser.page.press("[name=step]", "Enter")
    browser.until("document.querySelector('.plan').textContent.includes('h = 0.05')")
    browser.page.select_option("[name=boundary]", "periodic")
    browser.page.select_option("[name=cell]", "full-range")
    browser.page.select_option("[name=backend]", "reference")
    browser.until("document.querySelector('#where').textContent", "reference, float64")
    browser.until("location.hash.includes('boundary=periodic&cell=full-range&scheme=rk4&step=0.05&backend=reference')")
    browser.page.fill("[name=step]", "99")
    browser.page.press("[name=step]", "Enter")
    browser.until("document.querySelector('.cw-status').textContent.includes('stable')")
    browser.until("document.querySelector('#panel-run [name=step]').value", "0.05")  # what is refused is taken back
    browser.page.select_option("[name=scheme]", "")
    browser.page.fill("[name=accuracy]", "1e-3")
    browser.page.press("[name=accuracy]", "Enter")
    browser.until("document.querySelector('.plan').textContent.includes('0.001')")
