"""The pictures of docs/studio.md: ``python -m tests.kits.screenshots`` starts a studio and Chromium and writes them."""

import shutil
import time
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

from cnnsim.studio.session import Session
from cnnsim.studio.setup import first_setup
from tests.kits.paths import ROOT
from tests.kits.studio import FLAGS, serving

SIZE: Any = {"width": 1180, "height": 720}
SHOTS: dict[str, tuple[str, Any, str]] = {
    "studio.png": ("hole-filler", "light", "weights"),
    "studio-cell.png": ("hole-filler", "dark", "cell"),
}
"""File, template, colours and panel of each picture."""


def shoot(folder: Path) -> None:
    """Write all pictures into a folder."""
    from playwright.sync_api import sync_playwright

    chromium = shutil.which("chromium") or shutil.which("chromium-browser")
    for name, (template, colours, panel) in SHOTS.items():
        session = Session(first_setup(template, (64, 64)))
        with serving(lambda: session) as address, TemporaryDirectory() as profile, sync_playwright() as play:  # noqa: B023 - used in this round
            context = play.chromium.launch_persistent_context(
                profile, executable_path=chromium, args=FLAGS, viewport=SIZE, color_scheme=colours
            )
            page = context.pages[0]
            page.goto(address)
            while session.run.index < 130:  # the front is half way
                time.sleep(0.02)
            page.click("[name=play]")
            if panel == "cell":
                box = page.locator(".cw-pane canvas").nth(2).bounding_box()
                assert box is not None
                page.mouse.click(box["x"] + 0.17 * box["width"], box["y"] + 0.5 * box["height"])
            page.click(f"#tab-{panel}")
            time.sleep(1)
            page.screenshot(path=folder / name)
            context.close()


if __name__ == "__main__":
    shoot(ROOT / "docs")
