"""The pictures of docs/studio.md: ``python -m tests.kits.screenshots`` starts studios and Chromium and writes them."""

import shutil
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

from cnnsim.studio.session import Session
from cnnsim.studio.setup import first_setup
from tactile import Settings, open_source
from tactile.studio import PAGE
from tactile.studio.feed import Feed
from tactile.studio.model import ArrayModel
from tests.kits.paths import ROOT
from tests.kits.studio import FLAGS, serving

SIZE: Any = {"width": 1180, "height": 720}
SHOTS: dict[str, tuple[str, Any, str]] = {
    "studio.png": ("hole-filler", "light", "weights"),
    "studio-cell.png": ("hole-filler", "dark", "cell"),
}
"""File, template, colours and panel of each picture."""
TOUCHES: dict[str, tuple[str, float, Any, dict[str, str]]] = {
    "studio-touch.png": ("examples/scenes/grip.toml", 3.3, "light", {}),
    "studio-thresholds.png": ("examples/scenes/grip.toml", 5.2, "dark", {"contact_level": "0.71"}),
}
"""File, scene, time, colours and moved sliders of each picture of the live array view."""
SEEK = "t => { const s = document.querySelector('#scrub'); s.value = t; s.oninput() }"


@contextmanager
def shown(make_model: Callable[[], Any], colours: Any, page: Path | None = None) -> Iterator[Any]:
    """Serve a model and yield the page on it."""
    from playwright.sync_api import sync_playwright

    chromium = shutil.which("chromium") or shutil.which("chromium-browser")
    with serving(make_model, page=page) as address, TemporaryDirectory() as profile, sync_playwright() as play:
        context = play.chromium.launch_persistent_context(
            profile, executable_path=chromium, args=FLAGS, viewport=SIZE, color_scheme=colours
        )
        context.pages[0].goto(address)
        yield context.pages[0]
        context.close()


def until(page: Any, script: str) -> None:
    """Wait until a script of a page is true."""
    while not page.evaluate(script):
        time.sleep(0.05)


def shoot(folder: Path) -> None:
    """Write all pictures into a folder."""
    for name, (template, colours, panel) in SHOTS.items():
        session = Session(first_setup(template, (64, 64)))
        with shown(lambda: session, colours) as page:  # noqa: B023 - used in this round
            while session.run.index < 130:  # the front is half way
                time.sleep(0.02)
            page.click("[name=play]")
            if panel == "cell":
                box = page.locator(".cw-pane canvas").nth(2).bounding_box()
                page.mouse.click(box["x"] + 0.17 * box["width"], box["y"] + 0.5 * box["height"])
            page.click(f"#tab-{panel}")
            time.sleep(1)
            page.screenshot(path=folder / name)
    for name, (scene, at, colours, sliders) in TOUCHES.items():
        feed = Feed(open_source(ROOT / scene), Settings())
        feed.start()
        feed.wait()
        with shown(lambda: ArrayModel(feed), colours, PAGE) as page:  # noqa: B023 - used in this round
            until(page, "Number(document.body.dataset.t) > 0")
            page.evaluate(SEEK, at)
            for slider, value in sliders.items():
                page.fill(f"#{slider}", value)
                until(page, "document.querySelector('#options').textContent !== ''")
            time.sleep(2)
            page.screenshot(path=folder / name)


if __name__ == "__main__":
    shoot(ROOT / "docs")
