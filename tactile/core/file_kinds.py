"""Kinds of files that people write by hand for touch, told apart by their keys where one is given for another."""

from collections.abc import Mapping
from pathlib import Path
from typing import Any, Literal

from cnnsim.support import InputError

FileKind = Literal["scene", "array description", "detector", "calibration", "sweep"]
KINDS: dict[FileKind, tuple[tuple[str, ...], str]] = {
    "scene": (("cover", "load", "contact", "texture", "map"), "`tactile run`"),
    "array description": (("protocol",), "`tactile live --array`"),
    "detector": (("step", "event", "inputs"), "`tactile run --program`"),
    "calibration": (("shear_gain", "normal_gain", "taxel"), "`tactile run --calibration`"),
    "sweep": (("grid",), "`tactile sweep`"),
}
"""Kind -> keys that only it has, of which it has one at least; what takes it."""


def refuse_other_kind(table: Mapping[str, Any], where: str | Path, wanted: FileKind) -> None:
    """Refuse the table of a file that has keys of another kind, and none of the one that is wanted.

    Arguments: ``where`` is the file, or what names it in messages.

    Raises:
        InputError: what it is, and what takes it.
    """
    if not table.keys().isdisjoint(KINDS[wanted][0]):
        return
    for kind, (keys, taken) in KINDS.items():
        if kind != wanted and not table.keys().isdisjoint(keys):
            an = "an" if kind[0] in "aeiou" else "a"
            raise InputError(f"{where}: {an} {kind}, as {taken} takes it; a {wanted} wanted")
