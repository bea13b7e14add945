"""The grip scene as a feed that has ended, with a program of a user, and a page on it."""

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import pytest

from tactile import Settings, open_source
from tactile.pipeline import FrameReport, run
from tactile.studio import PAGE
from tactile.studio.feed import Feed
from tactile.studio.model import ArrayModel
from tests.kits.browser import Browser, opened
from tests.kits.serial import GRIP
from tests.kits.studio import serving

PROGRAM = """
name = "touched"
summary = "Pressed taxels and their number."
llm = ["touch", "pressed"]
wire = ["count"]
inputs = ["touch"]
outputs = ["pressed", "count"]
step = [{ logic = "and", of = ["touch", "touch"], to = "pressed" }, { wire = "count", of = "touch", to = "count" }]
"""


@dataclass
class Known:
    """A feed, and the reports of a run of its own on the same scene."""

    feed: Feed
    reports: list[FrameReport]

    def at(self, t: float) -> list[FrameReport]:
        """Return the newest report of each finger at a time."""
        before = [one for one in self.reports if one.frame.t <= t]
        return [[one for one in before if one.frame.finger == finger][-1] for finger in (0, 1)]


@pytest.fixture(scope="package")
def known(tmp_path_factory: pytest.TempPathFactory) -> Known:
    program = tmp_path_factory.mktemp("program") / "touched.toml"
    program.write_text(PROGRAM, encoding="utf-8")
    feed, reports = finished(Settings(programs=(str(program),))), list[FrameReport]()
    run(open_source(GRIP), Settings(), [reports.append])
    return Known(feed, reports)


def finished(settings: Settings, path: Path = GRIP) -> Feed:
    """Return a feed that has ended."""
    feed = Feed(open_source(path), settings)
    feed.start()
    feed.wait()
    assert not feed.failure
    return feed


@pytest.fixture(scope="package")
def browser(known: Known, tmp_path_factory: pytest.TempPathFactory) -> Iterator[Browser]:
    pytest.importorskip("starlette", reason="needs the extra studio")
    with (
        serving(lambda: ArrayModel(known.feed), page=PAGE) as address,
        opened(address, tmp_path_factory.mktemp("profile")) as one,
    ):
        one.until("Number(document.body.dataset.t) > 0")
        yield one
        assert not one.console
