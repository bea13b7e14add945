"""The accuracy page: Markdown, CSV, JSON and PNG of all sections, the plain-words answers first."""

import json
from collections.abc import Sequence
from pathlib import Path

from matplotlib.figure import Figure

from cnnsim.support.files import write_rows
from tests.benchmarks.accuracy.section import Section

_HEAD = """# What accuracy costs in time

Rebuilt by `make accuracy`; of one template of your own, on your own picture: `cnnsim accuracy TEMPLATE [PICTURE]`,
of a scene of your own: `tactile accuracy SCENE`.
"""


def write_page(
    sections: Sequence[Section], folder: Path, page: str = "accuracy", head: str = _HEAD, order: Sequence[str] = ()
) -> None:
    """Write ``PAGE/STEM.csv``, ``.json``, ``.png`` and ``.md`` of each section, and of all ``PAGE.md``.

    ``order`` has the stems of the page; of one that was not measured now, what was written before stays.
    """
    files = folder / page
    files.mkdir(parents=True, exist_ok=True)
    for section in sections:
        _write(section, files, page)
    texts = [files / f"{stem}.md" for stem in order or [section.stem for section in sections]]
    parts = [text.read_text(encoding="utf-8").split("\n", 1) for text in texts if text.exists()]
    lines = [head, *(answer for answer, _ in parts), *(rest.rstrip() for _, rest in parts)]
    (folder / f"{page}.md").write_text("\n".join(lines) + "\n", encoding="utf-8")


def _write(section: Section, files: Path, page: str) -> None:
    write_rows(files / f"{section.stem}.csv", section.rows)
    (files / f"{section.stem}.json").write_text(json.dumps(list(section.rows), indent=1) + "\n", encoding="utf-8")
    picture: list[str] = []
    if section.draw is not None:
        figure = Figure(figsize=section.size, layout="constrained")
        section.draw(figure)
        for axes in figure.axes:  # between the powers of ten there is little room
            axes.tick_params(which="minor", labelsize=5)
        figure.savefig(files / f"{section.stem}.png", dpi=90)
        picture = [f"![{section.title}]({page}/{section.stem}.png)", ""]
    lines = [
        f"- {section.answer}", "", f"## {section.title}", "", *picture, section.text.strip(), "",
        f"Figures: [CSV]({page}/{section.stem}.csv), [JSON]({page}/{section.stem}.json).",
    ]  # fmt: skip
    (files / f"{section.stem}.md").write_text("\n".join(lines) + "\n", encoding="utf-8")
