"""Kinds of TOML files for touch, recognised by their keys."""

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
"""Kind -> (its own keys, at least one of which is present; the command that takes it)."""


def refuse_other_kind(table: Mapping[str, Any], where: str | Path, wanted: FileKind) -> None:
    """Refuse the table of a file of another kind: keys of that kind, and none of the wanted one.

    Arguments: ``where`` names the file in messages.

    Raises:
        InputError: names the kind found and the command that takes it.
    """
    if not table.keys().isdisjoint(KINDS[wanted][0]):
        return
    for kind, (keys, taken) in KINDS.items():
        if kind != wanted and not table.keys().isdisjoint(keys):
            an = "an" if kind[0] in "aeiou" else "a"
            raise InputError(f"{where}: {an} {kind}, as {taken} takes it; a {wanted} wanted")
