"""The page of the live array view in Chromium: colours, arrows, loads, codes, events, curves and controls."""

from typing import Any

import numpy as np
import pytest
from matplotlib import colormaps
from matplotlib.colors import to_rgb

from tactile.output.plot_events import COLOURS
from tactile.output.plot_plane import ARROW, REACH
from tests.kits.browser import Browser
from tests.tactile.studio.conftest import Known

pytestmark = pytest.mark.slow

T = 2.0
"""Both fingers are held, and nothing slips."""
LOAD = (213, 94, 0)
BLUE, CONTACT, SLIP = (
    tuple(round(255 * part) for part in to_rgb(one)) for one in (ARROW, COLOURS["contact"], COLOURS["slip"])
)
BOXES = ".finger .box canvas"


def seek(browser: Browser, t: float) -> None:
    browser.page.evaluate("t => { const s = document.querySelector('#scrub'); s.value = t; s.oninput() }", t)
    browser.until("Number(document.body.dataset.t)", t)


def near(pixels: Any, colour: tuple[int, ...], most: int = 12) -> Any:
    """Return where pixels have about a colour."""
    return (np.abs(pixels[..., :3].astype(int) - colour) <= most).all(-1)


def squares(browser: Browser, finger: int) -> tuple[Any, float, float, float]:
    """Return the pixels of a finger of 2 x 2 taxels, its left and top edge, and the pitch in pixels."""
    pixels = browser.pixels(finger, BOXES)
    heights = [browser.pixels(n, BOXES).shape[:2] for n in (0, 1)]
    pitch = min(min(rows, cols) for rows, cols in heights) / 3
    return pixels, pixels.shape[1] / 2 - pitch, pixels.shape[0] / 2 - pitch, pitch


def test_squares_have_the_colours_of_the_pictures_on_one_scale(browser: Browser, known: Known) -> None:
    seek(browser, T)
    most = max(np.abs(report.frame.values[..., 2]).max() for report in known.reports)
    for finger, report in enumerate(known.at(T)):
        pixels, left, top, pitch = squares(browser, finger)
        for row, col in np.ndindex(2, 2):
            found = pixels[int(top + (row + 0.07) * pitch), int(left + (col + 0.5) * pitch), :3]
            wanted = colormaps["Greys"](min(1.0, -report.frame.values[row, col, 2] / most / 1.6))
            assert found == pytest.approx(255 * np.array(wanted[:3]), abs=2)


def test_nothing_is_interpolated_unless_asked(browser: Browser) -> None:
    seek(browser, T)
    pixels, left, top, pitch = squares(browser, 0)
    y = int(top + 0.07 * pitch)
    plain = pixels[y, int(left + 3) : int(left + pitch - 4), 0]
    assert np.ptp(plain) == 0
    browser.page.check("#smooth")
    browser.until("document.querySelector('#smooth').checked")
    browser.page.wait_for_timeout(600)
    smooth = browser.pixels(0, BOXES)[y, int(left + 3) : int(left + 2 * pitch - 4), 0]
    assert len(np.unique(smooth)) > 5
    browser.page.uncheck("#smooth")


def test_arrows_have_one_scale_and_a_key(browser: Browser, known: Known) -> None:
    seek(browser, T)
    most = max(np.hypot(report.frame.values[..., 0], report.frame.values[..., 1]).max() for report in known.reports)
    label = browser.page.get_attribute("#legend", "aria-label")
    assert "shear of 20 ‰" in label
    key = browser.pixels(0, "#legend")
    columns = np.flatnonzero(near(key, BLUE, 60).any(0))
    for finger, report in enumerate(known.at(T)):
        pixels, left, top, pitch = squares(browser, finger)
        assert np.ptp(columns) == pytest.approx(0.02 / most * REACH * pitch, abs=3)
        for row, col in np.ndindex(2, 2):
            x, y = left + col * pitch, top + row * pitch
            part = near(pixels[int(y) : int(y + pitch), int(x) : int(x + pitch)], BLUE, 60)
            shear = report.frame.values[row, col, :2] / most * REACH * pitch
            extents = [np.ptp(np.flatnonzero(part.any(axis))) for axis in (0, 1)]
            assert extents == pytest.approx(np.abs(shear), abs=9)  # a shaft and a head have a width


def test_the_load_has_its_place_and_newtons(browser: Browser, known: Known) -> None:
    seek(browser, T)
    for finger, report in enumerate(known.at(T)):
        pixels, left, top, pitch = squares(browser, finger)
        places = np.argwhere(near(pixels, LOAD))
        y, x = places.mean(0)
        wanted = (np.array([report.load.x, report.load.y]) / 0.0015 + 1) * pitch
        assert (x - left, y - top) == pytest.approx(tuple(wanted), abs=2)
        name = report.array.name
        assert browser.text(f"output[data-finger={name}]").startswith(f"{report.load.F:.2g} N at (")


def test_the_code_is_arrows_and_bits(browser: Browser, known: Known) -> None:
    seek(browser, T)
    for finger, report in enumerate(known.at(T)):
        arrows = browser.page.locator(".arrows").nth(finger).text_content()
        bits = browser.page.locator(".bits").nth(finger).text_content()
        assert arrows == report.code.arrows().replace(" ", "\n")
        assert int(bits.replace(" ", "").replace("\n", ""), 2) == report.code.signs()


def test_the_ribbon_has_spans_from_onset_to_end(browser: Browser, known: Known) -> None:
    seek(browser, 5.9)
    contact = next(one for report in known.reports for one in report.ended if one.key[:2] == ("left", "contact"))
    pixels = browser.pixels(0, "#ribbon")
    green = np.flatnonzero(near(pixels[8:9], CONTACT)[0])
    per_second = (pixels.shape[1] - 56) / 10
    assert green[0] == pytest.approx(52 + contact.t * per_second, abs=2)
    assert green[-1] == pytest.approx(52 + contact.end * per_second, abs=2)
    assert near(pixels, SLIP).any()
    assert browser.page.locator("#events li").count() == len([e for report in known.reports for e in report.events])
    seek(browser, T)
    green = np.flatnonzero(near(browser.pixels(0, "#ribbon")[8:9], CONTACT)[0])
    assert green[-1] == pytest.approx(52 + T * per_second, abs=2)  # it still lasts


def test_curves_rate_and_losses(browser: Browser) -> None:
    seek(browser, 3.5)
    browser.until("document.querySelectorAll('#charts canvas').length", 3)
    browser.page.wait_for_timeout(500)
    for chart in range(3):
        pixels = browser.pixels(chart, "#charts canvas")
        assert near(pixels, (0, 114, 178), 60).sum() > 5
        assert near(pixels, (213, 94, 0), 60).sum() > 5
    assert browser.text("#rate") == "400 frames/s"


def test_play_pause_step_and_scrub_by_mouse_and_keys(browser: Browser) -> None:
    seek(browser, 1.0)
    browser.page.click("#play")
    browser.until("Number(document.body.dataset.t) > 1.2")
    browser.page.click("#play")
    browser.page.evaluate("document.activeElement.blur()")
    browser.page.keyboard.press("Home")
    browser.until("document.querySelector('#clock').textContent", "t = 0.000 s")
    browser.page.keyboard.press(".")
    browser.until("document.querySelector('#clock').textContent", "t = 0.010 s")
    browser.page.keyboard.press(",")
    browser.until("document.querySelector('#clock').textContent", "t = 0.000 s")
    browser.page.keyboard.press("End")
    browser.until("Number(document.body.dataset.t)", 5.995)
    browser.page.keyboard.press("Space")  # from the end it begins again
    browser.until("Number(document.body.dataset.t) > 0.1 && Number(document.body.dataset.t) < 5")
    browser.page.keyboard.press("Space")
    browser.page.focus("#scrub")
    browser.page.keyboard.press("ArrowRight")
    browser.until("document.querySelector('#play').textContent", "▶ Play")


def test_thresholds_make_the_events_again(browser: Browser, known: Known) -> None:
    seek(browser, 5.5)
    run = len([one for one in known.feed.events_between(0.5, 5.5) if one.t >= 0.5 and one.told <= 5.5])
    browser.page.fill("#dead_band", "0.7")
    browser.until("document.querySelector('#options').textContent", "--dead-band 0.0196 --hysteresis 0.0005")
    browser.page.fill("#hysteresis", "0.7")
    browser.page.fill("#contact_level", "0.71")
    browser.until(
        "document.querySelector('#options').textContent.endsWith('--hysteresis 0.0098 --contact-level 0.0202')"
    )
    assert browser.text("#again").endswith(f"the run has {run}.")
    assert 0 < int(browser.text("#again").split()[0]) != run
    height = browser.page.evaluate("document.querySelector('#ribbon').clientHeight")
    browser.page.click("#reset")
    browser.until("document.querySelector('#options').textContent", "")
    browser.until(f"document.querySelector('#ribbon').clientHeight < {height}")  # without the rows of these events


def test_a_click_on_an_event_goes_to_its_onset(browser: Browser) -> None:
    seek(browser, 5.5)
    browser.page.click("#events li:last-child")
    onset = float(browser.page.get_attribute("#events li:last-child", "data-t") or "")
    browser.until("Number(document.body.dataset.t)", onset)
    seek(browser, 5.5)
    width = browser.pixels(0, "#ribbon").shape[1]
    browser.page.click("#ribbon", position={"x": 52 + 3 * (width - 56) / 10, "y": 8})  # the first contact
    browser.until("Number(document.body.dataset.t)", onset)


def test_the_planes_of_a_program_are_next_to_the_taxels(browser: Browser, known: Known) -> None:
    seek(browser, T)
    for finger, report in enumerate(known.at(T)):
        pixels = browser.pixels(finger, "figure[data-output=pressed] canvas")
        assert np.array_equal(pixels[..., 0] == 0, report.code.contact)
        count = browser.page.locator("figure[data-output=count] b").nth(finger).text_content()
        assert count == str(report.code.contact.sum())


@pytest.mark.parametrize("colours", ["light", "dark"])
def test_all_is_within_the_window_and_named(colours: Any, browser: Browser) -> None:
    browser.page.emulate_media(color_scheme=colours)
    seek(browser, T)
    size = browser.page.evaluate("[document.documentElement.scrollWidth, document.documentElement.scrollHeight]")
    assert size == [1024, 700]
    for name in ("#scrub", "#charts", "#events", "footer", ".finger .load"):
        box = browser.page.locator(name).first.bounding_box()
        assert box is not None
        assert box["y"] + box["height"] <= 700
    ink, paper = browser.page.evaluate(
        "[getComputedStyle(document.body).color, getComputedStyle(document.body).backgroundColor]"
    )
    light = [sum(map(int, one[4:-1].split(","))) / 765 for one in (ink, paper)]
    assert abs(light[0] - light[1]) > 0.7
    nameless = (
        "[...document.querySelectorAll('button, input, select, canvas[role]')].filter((one) => one.offsetParent"
        " && !(one.textContent.trim() || one.ariaLabel || one.title || one.labels?.length)).map((one) => one.outerHTML)"
    )
    assert browser.page.evaluate(nameless) == []
