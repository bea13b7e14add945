"""A section of the accuracy page: its figures as rows, its plain words, and what draws its diagram."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

Draw = Callable[[Any], None]


@dataclass(frozen=True)
class Section:
    """One section.

    ``stem`` names its files, ``answer`` has one or two short sentences on top of the page, ``see`` says what the
    diagram shows, ``text`` has the paragraphs (Markdown),
    ``rows`` the figures for CSV and JSON, all with the same keys; ``draw`` draws into a figure of matplotlib of
    ``size`` [inch], None for no diagram.
    """

    stem: str
    title: str
    answer: str
    text: str
    rows: Sequence[dict[str, Any]]
    draw: Draw | None = None
    size: tuple[float, float] = (11.0, 10.0)
    see: str = ""
