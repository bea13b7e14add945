"""The picture and the recording that the examples read, and the links of the README that is written with them."""

import re

from cnnsim import read_picture
from cnnsim.cli.examples import sources
from cnnsim.cli.pictures import arrow
from tactile.sources import open_source
from tests.kits.example_files import PICTURE, RECORDING, SCENE, scan
from tests.kits.paths import ROOT


def test_links_of_the_written_readme_lead_to_written_files() -> None:
    there = {*sources()} | {name.rpartition("/")[0] for name in sources()}
    links = [
        link for link in re.findall(r"\]\(([^)#\s]+)", (ROOT / "README.md").read_text("utf-8")) if "://" not in link
    ]
    assert len(links) > 10
    assert [link for link in links if link.rstrip("/") not in there] == []


def test_files_of_one_series_are_a_range_and_others_are_not() -> None:
    assert arrow(["a-0.png", "a-1.png", "a-2.png"]) == " -> a-0.png to a-2.png"
    assert arrow(["filled.png", "wave.gif"]) == " -> filled.png, wave.gif"
    assert arrow(["a.png"]) == " -> a.png"


def test_they_are_what_the_code_makes() -> None:
    assert abs(read_picture(PICTURE) - scan()).max() <= 1 / 255
    assert RECORDING.stat().st_size < 300_000
    kept, made = open_source(RECORDING), open_source(SCENE)
    assert [array.name for array in kept.arrays] == [array.name for array in made.arrays]
    for ours, theirs in zip(kept, made, strict=True):
        assert abs(ours.values - theirs.values).max() < 1e-12
        if ours.t > 0.1:
            break
