"""Draws what `robust` measured: share of wrong cells against error level."""

from pathlib import Path

from cnnsim.prototyping.robust.report import Robustness
from cnnsim.support.files import writing


def draw_robustness(found: Robustness, path: str | Path) -> None:
    """Write the three curves; the format follows the name's ending.

    Raises:
        InputError: the file cannot be written.
    """
    with writing(path) as beside:
        found.figure().savefig(beside, dpi=120)
