"""Pages are easy to read: short sentences, and no page of rules that is too long."""

import re
from pathlib import Path
from statistics import median

import pytest

from tests.kits.paths import FILE_PAGES, ROOT

PAGES = [
    *sorted(ROOT.glob("*.md")),
    *(path for path in sorted((ROOT / "docs").rglob("*.md")) if "generated" not in path.parts),
    *FILE_PAGES,
]  # fmt: skip
DATA = {"CHANGELOG.md", "docs/hard-cases/all.md", "docs/accuracy/library.md"}
"""Pages of data, which may be long."""


def sentences(text: str) -> list[str]:
    """Return the sentences of a page outside of code, tables and titles."""
    text = re.sub(r"```.*?```", "", text, flags=re.DOTALL)
    text = re.sub(r"^(\|.*|#.*)$", "", text, flags=re.MULTILINE)
    found: list[str] = []
    for block in re.split(r"\n\s*\n|\n(?=\s*[-*] |\s*\d+\. )", text):
        plain = re.sub(r"`[^`]*`", "code", re.sub(r"!?\[([^]]*)\]\([^)]*\)", r"\1", " ".join(block.split())))
        found += re.split(r"(?<=[.!?:;])\s+(?=[A-Z*`\"(])", plain)
    return [one for one in found if len(one.split()) > 1]


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.relative_to(ROOT).as_posix())
def test_sentences_are_short(page: Path) -> None:
    lengths = {one: len(one.split()) for one in sentences(page.read_text(encoding="utf-8"))}
    if lengths:
        assert median(lengths.values()) < 20
        assert max(lengths.values()) <= 40, max(lengths, key=lambda one: lengths[one])


def test_no_page_of_rules_is_long() -> None:
    words = {page.relative_to(ROOT).as_posix(): len(page.read_text(encoding="utf-8").split()) for page in PAGES}
    assert {name for name, count in words.items() if count > 1500} <= DATA
