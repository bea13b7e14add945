"""The accuracy page: answers first, a figure, and a page behind it with text, tables, CSV and JSON of each section."""

import json
from collections.abc import Sequence
from pathlib import Path

from matplotlib.figure import Figure
from matplotlib.ticker import NullFormatter

from cnnsim.support.files import write_rows
from tests.benchmarks.accuracy.section import Section

_HEAD = """# What accuracy costs in time

`cnnsim accuracy TEMPLATE [PICTURE]` measures a template of your own, `tactile accuracy SCENE` a scene of your own.
`make accuracy` measures this page again. Times are of one machine, so look at the ratios.
"""
SMALLEST = 7.5
"""[pt] Font of tick labels."""


def write_page(
    sections: Sequence[Section], folder: Path, page: str = "accuracy", head: str = _HEAD, order: Sequence[str] = ()
) -> None:
    """Write ``PAGE/STEM.csv``, ``.json``, ``.png`` and ``.md`` of each section, and ``PAGE.md`` with the answers.

    ``order`` has the stems of the page; of one that was not measured now, what was written before stays.
    """
    files = folder / page
    files.mkdir(parents=True, exist_ok=True)
    for section in sections:
        _write(section, files)
    (folder / f"{page}.md").write_text(front(files, page, head, order or [one.stem for one in sections]), "utf-8")


def front(files: Path, page: str, head: str, order: Sequence[str]) -> str:
    """Return the front page: the answer of each section with a link to its page, and the first figure."""
    lines, figure = [head], list[str]()
    for stem in order:
        if not (files / f"{stem}.md").exists():
            continue
        title, answer, *rest = (files / f"{stem}.md").read_text(encoding="utf-8").split("\n\n")
        lines.append(f"- [{title.removeprefix('# ')}]({page}/{stem}.md): {answer}")
        if not figure and rest[1:2] and rest[1].startswith("!["):
            figure = ["", rest[0], "", rest[1].replace("](", f"]({page}/")]
    return "\n".join([*lines, *figure]) + "\n"


def _write(section: Section, files: Path) -> None:
    write_rows(files / f"{section.stem}.csv", section.rows)
    (files / f"{section.stem}.json").write_text(json.dumps(list(section.rows), indent=1) + "\n", encoding="utf-8")
    picture = ""
    if section.draw is not None:
        draw(section, files)
        picture = f"{section.see}\n\n![{section.title}]({section.stem}.png)\n\n"
    (files / f"{section.stem}.md").write_text(
        f"# {section.title}\n\n{section.answer}\n\n{picture}{section.text.strip()}\n\n"
        f"Figures: [CSV]({section.stem}.csv), [JSON]({section.stem}.json).\n", encoding="utf-8"
    )  # fmt: skip


def draw(section: Section, files: Path) -> None:
    """Write the figure of a section, without labels between the powers of ten."""
    assert section.draw is not None
    figure = Figure(figsize=section.size, layout="constrained")
    section.draw(figure)
    for axes in figure.axes:
        axes.tick_params(labelsize=SMALLEST)
        for axis in (axes.xaxis, axes.yaxis):
            axis.set_minor_formatter(NullFormatter())
    figure.savefig(files / f"{section.stem}.png", dpi=90)
