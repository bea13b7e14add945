"""Header of recordings: TOML text with the arrays, units and origin of the frames, in SI units.

CSV stores it in comment lines, NPZ in the array ``tactile``, Parquet in its metadata, MCAP in a metadata record:

    tactile_recording = 1
    title = "grip"
    youngs_modulus_pa = 2400000.0          (optional)
    start_ns = 1700000000000000000         (Unix time at which t is 0; optional)
    untared = true                         (readings contain device offsets; optional)
    array_description = "..."              (text of the device's array description; optional)
    live_choices = "..."                   (options of the live run, as JSON; optional)
    damage = "..."                         (the damaged recording from which the frames come; optional)
    [[finger]]
    name = "left"
    rows = 2
    cols = 2
    pitch_m = 0.0015
    depth_m = 0.0015
    thickness_m = 0.002                    (of the cover; optional)
    origin_m = [0.0, 0.0]
    quantity = "strain"                    (strain, stress or force)
    shear = false                          (the taxels measure the normal alone; optional)
    calibrated = false                     (readings are in the unit of the wire; optional)
"""

from collections.abc import Iterable
from typing import Any, NamedTuple

from cnnsim.support import InputError
from cnnsim.support.toml_file import check_keys, parse_toml, take, take_tables
from tactile.core.array_table import array_table, take_array, toml_text
from tactile.core.frame import Frame, TaxelArray
from tactile.core.source import FrameStream, Provenance, Source, provenance

TOP_KEYS = (
    "tactile_recording", "title", "youngs_modulus_pa", "start_ns", "untared", "array_description", "live_choices",
    "damage", "finger",
)  # fmt: skip
FINGER_KEYS = ("name", "rows", "cols", "pitch_m", "depth_m", "thickness_m", "origin_m", "quantity", "shear",
               "calibrated")  # fmt: skip
NEEDED = ("name", "rows", "cols", "pitch_m", "depth_m", "quantity")


class RecordingHeader(NamedTuple):
    """Contents of a header: title, modulus [Pa] and arrays as in ``Source``, and the provenance."""

    title: str
    modulus: float | None
    arrays: tuple[TaxelArray, ...]
    provenance: Provenance

    def stream(self, frames: Iterable[Frame], count: int | None) -> FrameStream:
        """Return a source of ``count`` frames with this header."""
        return FrameStream(self.title, self.arrays, self.modulus, count, frames, self.provenance)


def header_text(source: Source) -> str:
    """Return the header of a source; reading it back gives the same numbers bit for bit.

    Raises:
        InputError: two fingers have the same name.
    """
    names = [array.name for array in source.arrays]
    if len(set(names)) < len(names):
        raise InputError(f"fingers {names}: distinct names wanted")
    known = provenance(source)
    top: dict[str, Any] = {"tactile_recording": 1, "title": source.title}
    if source.modulus is not None:
        top["youngs_modulus_pa"] = float(source.modulus)
    if known.start_ns is not None:
        top["start_ns"] = known.start_ns
    if known.untared:
        top["untared"] = True
    if known.description:
        top["array_description"] = known.description
    if known.choices:
        top["live_choices"] = known.choices
    if known.damage:
        top["damage"] = known.damage
    raw = {name: {"calibrated": False} for name in known.uncalibrated}
    return toml_text(top, (array_table(array, "m") | raw.get(array.name, {}) for array in source.arrays))


def read_header(text: str, where: str, place: str = "") -> RecordingHeader:
    """Return the contents of a header; ``where`` names the file in messages, ``place`` the header in it.

    Raises:
        InputError: invalid TOML, an unknown or missing key, a wrong value, no finger or a name used twice.
    """
    table = parse_toml(text, f"{where}: {place}" if place else where)
    check_keys(table, TOP_KEYS, where, ("tactile_recording",))
    version = take(table, "tactile_recording", int, where)
    if version != 1:
        raise InputError(f"{where}: tactile_recording = {version}, 1 wanted")
    modulus = take(table, "youngs_modulus_pa", float, where) if "youngs_modulus_pa" in table else None
    if modulus is not None and modulus <= 0:
        raise InputError(f"{where}: youngs_modulus_pa = {modulus}, a positive number wanted")
    arrays, raw = [], []
    for number, finger in enumerate(take_tables(table, "finger", where), 1):
        at = f"{where}: finger {number}"
        check_keys(finger, FINGER_KEYS, at, NEEDED)
        arrays.append(take_array(finger, "m", at))
        if not _flag(finger, "calibrated", at, True):
            raw.append(arrays[-1].name)
    names = [array.name for array in arrays]
    if not names or len(set(names)) < len(names):
        raise InputError(f"{where}: fingers {names}, at least one [[finger]] and no name twice wanted")
    start = take(table, "start_ns", int, where) if "start_ns" in table else None
    texts = (take(table, key, str, where, "") for key in ("array_description", "live_choices", "damage"))
    known = Provenance(_flag(table, "untared", where, False), tuple(raw), start, *texts)
    return RecordingHeader(take(table, "title", str, where, ""), modulus, tuple(arrays), known)


def _flag(table: dict[str, Any], key: str, where: str, default: bool) -> bool:
    value = table.get(key, default)
    if not isinstance(value, bool):
        raise InputError(f"{where}: {key} = {value!r}, true or false wanted")
    return value
