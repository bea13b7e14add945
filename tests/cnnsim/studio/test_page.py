"""The page of the playground in a real Chromium: every part is used by clicks and keys and looked at by pixels."""

import shutil
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from PIL import Image

sync_api = pytest.importorskip("playwright.sync_api", reason="needs playwright")
CHROMIUM = shutil.which("chromium") or shutil.which("chromium-browser")
if CHROMIUM is None:
    pytest.skip("needs Chromium: apt-get install chromium", allow_module_level=True)

from cnnsim import library  # noqa: E402 - after the checks above
from cnnsim.studio.session import Session  # noqa: E402
from cnnsim.studio.setup import first_setup  # noqa: E402
from tests.kits.studio import FLAGS, serving  # noqa: E402

pytestmark = pytest.mark.slow

LEFT, RIGHT, OVERLAY = 0, 2, 3
"""Canvases of the view: the input, the state, and what lies over it."""


class Browser:
    """The page, with what its console says."""

    def __init__(self, page: Any, address: str) -> None:
        self.page, self.address, self.console = page, address, list[str]()
        page.on("console", lambda message: self.console.append(message.text))
        page.on("pageerror", lambda error: self.console.append(str(error)))

    def until(self, script: str, wanted: Any = True, seconds: float = 60) -> None:
        """Wait until a script has a value; the page's policy refuses playwright's own way."""
        end = time.monotonic() + seconds
        while (found := self.page.evaluate(script)) != wanted:
            assert time.monotonic() < end, f"{script} is {found}, {wanted} wanted; {self.console}"
            time.sleep(0.02)

    def pixels(self, number: int) -> Any:
        """Return the colours (rows, cols, 4) of a canvas."""
        script = """n => { const c = document.querySelectorAll('.cw-pane canvas')[n];
            const copy = new OffscreenCanvas(c.width, c.height).getContext('2d', {willReadFrequently: true});
            copy.drawImage(c, 0, 0);
            return [c.height, c.width, [...copy.getImageData(0, 0, c.width, c.height).data]] }"""
        rows, cols, data = self.page.evaluate(script, number)
        return np.array(data, np.uint8).reshape(rows, cols, 4)

    def at(self, number: int, row: float, col: float) -> tuple[float, float]:
        """Return where the middle of a cell of a canvas is on the screen."""
        box = self.page.locator(".cw-pane canvas").nth(number).bounding_box()
        rows, cols = self.pixels(number).shape[:2]
        return box["x"] + (col + 0.5) * box["width"] / cols, box["y"] + (row + 0.5) * box["height"] / rows

    def drag(self, number: int, *cells: tuple[int, int]) -> None:
        """Draw a line through cells."""
        self.page.mouse.move(*self.at(number, *cells[0]))
        self.page.mouse.down()
        for cell in cells[1:]:
            self.page.mouse.move(*self.at(number, *cell), steps=4)
        self.page.mouse.up()

    def shows(self, number: int, wanted: Callable[[Any], Any]) -> None:
        """Wait until the colours of a canvas are as wanted: a picture follows its numbers by a frame or more."""
        end = time.monotonic() + 60
        while not wanted(self.pixels(number).astype(int)):
            assert time.monotonic() < end, self.pixels(number)[..., 0]
            time.sleep(0.02)

    def text(self, selector: str) -> str:
        return str(self.page.text_content(selector))

    def open(self, link: str) -> None:
        """Go to a link of the page, and stop there at t = 0."""
        self.page.evaluate("link => { location.hash = link }", link)
        self.until("document.body.dataset.link", link)
        self.stop()

    def stop(self) -> None:
        """Stop where it is, then go to the start."""
        if "Pause" in self.text("[name=play]"):
            self.page.click("[name=play]")
        self.page.click("[name=restart]")
        self.until("document.querySelector('[name=clock]').textContent", "t = 0.00")

    def orange(self) -> None:
        """Wait until a cell in the middle is above +1."""
        end = time.monotonic() + 60
        while not (colour := self.pixels(RIGHT)[8, 8].astype(int))[0] > colour[2]:
            assert time.monotonic() < end

    def rest(self) -> None:
        """Play until the network is at rest."""
        self.page.select_option("[name=speed]", "10")
        self.page.click("[name=play]")
        self.until("document.querySelector('.cw-status').textContent.startsWith('at rest')")


@pytest.fixture(scope="module")
def browser(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Browser]:
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


@pytest.fixture(autouse=True)
def no_console_error(browser: Browser) -> Iterator[None]:
    yield
    browser.page.keyboard.press("Escape")  # closes a dialog
    said, browser.console[:] = list(browser.console), []
    assert not said


EMPTY = "template=hole-filler&size=16x16&picture=white&seed=0"


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


def test_a_clicked_cell_shows_its_route(browser: Browser) -> None:
    browser.open("template=hole-filler&size=16x16&picture=curves&seed=1")
    for _ in range(3):
        browser.page.click("[name=next]")
    browser.page.mouse.click(*browser.at(RIGHT, 5, 9))
    browser.until("document.querySelector('[name=cell-title]').textContent.startsWith('cell (5, 9)')")
    assert browser.page.locator("#panel-cell .uplot").count() == 2
    assert browser.page.locator("#panel-cell .parts .weight").count() == 18
    assert "stable" in browser.text("#panel-cell .about")
    browser.page.locator(".cw-pane canvas").nth(RIGHT).focus()
    browser.page.keyboard.press("ArrowDown")
    browser.page.keyboard.press("Enter")
    browser.until("document.querySelector('[name=cell-title]').textContent.startsWith('cell (6, 9)')")


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
