"""The page of the playground in Chromium: clicks, keys, and the colours of its canvases."""

import shutil
import time
from base64 import b64decode
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from tests.kits.studio import FLAGS

LEFT, RIGHT, OVERLAY = 0, 2, 3
"""Canvases of the view: the input, the state, and the overlay of the state."""


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

    def pixels(self, number: int, canvases: str = ".cw-pane canvas") -> Any:
        """Return the colours (rows, cols, 4) of a canvas."""
        script = """([n, canvases]) => { const c = document.querySelectorAll(canvases)[n];
            const copy = new OffscreenCanvas(c.width, c.height).getContext('2d', {willReadFrequently: true});
            copy.drawImage(c, 0, 0);
            const data = copy.getImageData(0, 0, c.width, c.height).data;
            let text = '';
            for (let i = 0; i < data.length; i += 8192) text += String.fromCharCode(...data.subarray(i, i + 8192));
            return [c.height, c.width, btoa(text)] }"""
        rows, cols, data = self.page.evaluate(script, [number, canvases])
        return np.frombuffer(b64decode(data), np.uint8).reshape(rows, cols, 4)

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

    def shows(self, number: int, wanted: Callable[[Any], Any], canvases: str = ".cw-pane canvas") -> None:
        """Wait until the colours of a canvas are as wanted: a picture follows its numbers by a frame or more."""
        end = time.monotonic() + 60
        while not wanted(self.pixels(number, canvases).astype(int)):
            assert time.monotonic() < end, self.pixels(number, canvases)[..., 0]
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


@contextmanager
def opened(address: str, profile: Path, colours: str = "light") -> Iterator[Browser]:
    """Open a page in Chromium; skip where it is absent."""
    sync_api = pytest.importorskip("playwright.sync_api", reason="needs playwright")
    chromium = shutil.which("chromium") or shutil.which("chromium-browser")
    if chromium is None:
        pytest.skip("needs Chromium: apt-get install chromium")
    with sync_api.sync_playwright() as play:
        context = play.chromium.launch_persistent_context(
            profile, executable_path=chromium, args=FLAGS, viewport={"width": 1024, "height": 700}, color_scheme=colours
        )
        context.set_default_timeout(8000)
        one = Browser(context.pages[0], address)
        one.page.goto(address)
        yield one
        context.close()


EMPTY = "template=hole-filler&size=16x16&picture=white&seed=0"
"""Link of a white picture."""
