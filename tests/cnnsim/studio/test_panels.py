"""The panels of the playground in Chromium: cell, library, precision, files, programs, layout and keyboard."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from PIL import Image

from cnnsim import library
from tests.kits.browser import EMPTY, LEFT, OVERLAY, RIGHT, Browser

pytestmark = [pytest.mark.slow, pytest.mark.usefixtures("no_console_error")]


def test_a_clicked_cell_shows_its_route(browser: Browser) -> None:
    browser.open("template=hole-filler&size=16x16&picture=curves&seed=1")
    for _ in range(3):
        browser.page.click("[name=next]")
    browser.page.mouse.click(*browser.at(RIGHT, 5, 9))
    browser.until("document.querySelector('[name=cell-title]').textContent.startsWith('row 5, column 9')")
    assert browser.page.locator("#panel-cell .uplot").count() == 2
    assert browser.page.locator("#panel-cell .parts .weight").count() == 18
    assert "stable" in browser.text("#panel-cell .about")
    browser.page.locator(".cw-pane canvas").nth(RIGHT).focus()
    browser.page.keyboard.press("ArrowDown")
    browser.page.keyboard.press("Enter")
    browser.until("document.querySelector('[name=cell-title]').textContent.startsWith('row 6, column 9')")


def test_the_library_is_searched_compared_and_opened(browser: Browser) -> None:
    browser.open(EMPTY)
    browser.page.click("#tab-library")
    browser.page.fill("[name=words]", "logic-not")
    browser.until("document.querySelectorAll('.list li').length < 9")
    browser.page.click("[data-name=logic-not]")
    browser.until("document.querySelector('#name').textContent", "logic-not")
    browser.until("document.querySelector('.example h3')?.textContent", "Worked example 0 of logic-not PASS")
    browser.page.click("[name=check]")
    browser.until("document.querySelector('[name=all]').textContent.includes('pass')")
    count = len(library.load("logic-not").examples)
    assert browser.text("[name=all]") == f"{count} of {count} pass"
    browser.page.fill("[name=words]", "median")
    browser.page.click("[data-name=median]")
    browser.until("document.querySelector('#name').textContent", "median")
    browser.page.click("#tab-weights")
    assert browser.page.locator(".term").count() == 1
    browser.page.fill("[aria-label='value 0']", "-0.5")  # of the term's table
    browser.until("document.querySelector('#name').textContent", "median (changed)")
    browser.open("template=autowave&size=16x16&picture=dot&seed=0")
    browser.page.select_option("[name=weights-layer]", "1")
    browser.page.fill("[aria-label='time constant of the layer']", "2")
    browser.until("document.querySelector('#name').textContent", "autowave (changed)")
    browser.page.select_option("[name=layer]", "1")
    browser.until("document.querySelector('.cw-status').className", "cw-status")


def test_failing_chips_are_red(browser: Browser) -> None:
    browser.open("template=edge&size=16x16&picture=shapes&seed=0")
    browser.page.click("#tab-chips")
    browser.page.fill("[name=sigma]", "0.3")
    browser.page.fill("[name=chips]", "6")
    browser.page.click("[name=run-chips]")
    browser.until("document.querySelector('[name=chips-result]').textContent.includes('of 6 chips')")
    over = browser.pixels(OVERLAY)
    assert over[..., 3].max() > 0
    assert (over[over[..., 3] > 0][:, 0] > 150).all()


def test_accuracy_is_drawn_against_time(browser: Browser) -> None:
    browser.open("template=diffusion&size=16x16&picture=waves&seed=0")
    browser.page.click("#tab-chips")
    browser.page.click("[name=run-accuracy]")
    browser.until("document.querySelector('[name=accuracy-result]').textContent.includes('24 of 24')")
    assert browser.page.locator("#panel-chips .uplot").count() == 1


def test_a_link_opens_the_same_run_and_text_can_be_copied(browser: Browser) -> None:
    link = "template=edge&size=20x30&picture=shapes&seed=4&boundary=periodic"
    browser.open(link)
    assert browser.pixels(RIGHT).shape[:2] == (20, 30)
    before = browser.pixels(LEFT)
    browser.open(EMPTY)
    browser.open(link)
    assert np.array_equal(browser.pixels(LEFT), before)
    for button, part in (("link", "#" + link), ("python", "run('edge', picture, boundary='periodic')"),
                         ("command", "cnnsim run edge picture.png")):  # fmt: skip
        browser.page.click(f"#copy-{button}")
        browser.until("document.querySelector('dialog').open")
        browser.until(f"document.querySelector('#copied').textContent.includes({part!r})")
        browser.page.click("#close")


@pytest.mark.parametrize("what", ["toml", "png", "gif"])
def test_files_are_saved(what: str, browser: Browser, tmp_path: Path) -> None:
    browser.page.click("[name=next]")
    with browser.page.expect_download() as saved:
        browser.page.select_option("#save", what)
    path = tmp_path / saved.value.suggested_filename
    saved.value.save_as(path)
    if what == "toml":
        assert library.load_file(path).name == path.stem
    else:
        with Image.open(path) as image:
            image.load()


def test_pictures_are_made_pasted_and_dropped(browser: Browser, tmp_path: Path) -> None:
    browser.open(EMPTY)
    browser.page.select_option("[name=picture]", "ramp")
    browser.until("location.hash.includes('picture=ramp')")
    levels = browser.pixels(LEFT)[0, :, 0].astype(int)
    assert (np.diff(levels) > 0).all()
    browser.page.click("[name=noise]")
    browser.until("location.hash.includes('drawn=')")
    assert len(np.unique(browser.pixels(LEFT)[..., 0])) > 50
    send = """async kind => { const c = new OffscreenCanvas(24, 12), x = c.getContext('2d'); x.fillRect(0, 0, 12, 12);
        const file = new File([await c.convertToBlob()], 'half.png', {type: 'image/png'}), data = new DataTransfer();
        data.items.add(file);
        window.dispatchEvent(kind === 'drop' ? new DragEvent('drop', {dataTransfer: data, cancelable: true})
            : new ClipboardEvent('paste', {clipboardData: data})); }"""
    for kind in ("drop", "paste"):
        browser.open(EMPTY)
        browser.page.evaluate(send, kind)
        browser.until("document.querySelectorAll('.cw-pane canvas')[0].width", 24)
        picture = browser.pixels(LEFT)[..., 0]
        assert (picture[:, :12] == 0).all(), kind
        assert (picture[:, 12:] == 255).all(), kind


def test_a_program_is_a_strip_whose_steps_open(browser: Browser) -> None:
    browser.open("template=edge&size=16x16&picture=shapes&seed=0")
    browser.page.click("#tab-programs")
    browser.until("document.querySelector('[name=program]').value", "skeleton")
    browser.page.click("[name=run-program]")
    browser.until("document.querySelectorAll('.steps li').length > 8")
    browser.page.locator(".steps button").nth(2).click()
    assert "skeleton-1" in browser.text("#panel-programs .example")
    browser.page.click("[name=open-step]")
    browser.until("document.querySelector('#name').textContent", "skeleton-1")


def test_the_view_renders_for_any_host_as_in_a_notebook(browser: Browser) -> None:
    browser.page.evaluate("""async () => {
        const [{SocketModel}, view] = await Promise.all([import('/page/socket.js'), import('/page/view.js')]);
        const el = document.createElement('div');
        el.id = 'host';
        document.body.append(el);
        const model = new SocketModel(() => view.default.render({model, el}), () => {});
    }""")
    browser.until("document.querySelectorAll('#host canvas').length", 4)
    browser.until("Number(document.querySelector('#host [name=scrub]').value) > 3")
    browser.page.evaluate("document.querySelector('#host [name=play]').click()")
    browser.page.evaluate("document.querySelector('#host').remove()")


@pytest.mark.parametrize("scheme", ["light", "dark"])
@pytest.mark.parametrize("size", [(1024, 700), (1440, 900)])
def test_everything_fits_and_can_be_read(scheme: Any, size: tuple[int, int], browser: Browser) -> None:
    browser.page.set_viewport_size({"width": size[0], "height": size[1]})
    browser.page.emulate_media(color_scheme=scheme)
    for tab in ("weights", "run", "cell", "library", "chips", "programs"):
        browser.page.click(f"#tab-{tab}")
        beyond = browser.page.evaluate("""() => [...document.querySelectorAll('button, select, input, output, canvas')]
            .filter(e => e.offsetParent && !e.closest('[role=tabpanel]'))
            .map(e => [e.name || e.id, e.getBoundingClientRect()])
            .filter(([_, r]) => r.right > innerWidth + 1 || r.bottom > innerHeight + 1 || r.left < -1)""")
        assert not beyond, (tab, beyond)
        assert browser.page.evaluate("document.documentElement.scrollWidth <= innerWidth")
        wide = (
            f"document.querySelector('#panel-{tab}').scrollWidth <= document.querySelector('#panel-{tab}').clientWidth"
        )
        assert browser.page.evaluate(wide), tab
    assert contrast(browser) > 4.5
    browser.page.set_viewport_size({"width": 1024, "height": 700})


def contrast(browser: Browser) -> float:
    """Return the least contrast of text on the page's background, as WCAG defines it."""
    script = """() => ['--ink', '--soft', '--wrong', '--good', '--paper']
        .map(name => getComputedStyle(document.body).getPropertyValue(name))"""
    *inks, paper = [_luminance(colour.strip()) for colour in browser.page.evaluate(script)]
    return min((max(ink, paper) + 0.05) / (min(ink, paper) + 0.05) for ink in inks)


def _luminance(colour: str) -> float:
    digits = colour[1:] if len(colour) == 7 else "".join(2 * digit for digit in colour[1:])
    parts = np.array([int(digits[i : i + 2], 16) for i in (0, 2, 4)]) / 255
    linear = np.where(parts <= 0.03928, parts / 12.92, ((parts + 0.055) / 1.055) ** 2.4)
    return float(linear @ (0.2126, 0.7152, 0.0722))


def test_all_controls_are_reached_by_the_tab_key(browser: Browser) -> None:
    browser.page.click("#tab-weights")
    browser.page.focus("#copy-link")
    names = set()
    for _ in range(60):
        browser.page.keyboard.press("Tab")
        names.add(
            browser.page.evaluate("(e => e.name || e.id || e.getAttribute('aria-label') || '')(document.activeElement)")
        )
    assert {"play", "restart", "scrub", "speed", "rest", "brush", "save", "tab-weights"} <= names
    browser.page.focus("#tab-weights")
    browser.page.keyboard.press("ArrowRight")
    assert browser.page.is_visible("#panel-run")
