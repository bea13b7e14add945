"""Calibration of a skin as a scan or weights measured it: the TOML file that `calibrate` writes and `run` reads."""

from dataclasses import dataclass
from pathlib import Path
from typing import Any

from cnnsim.support import InputError
from cnnsim.support.files import named_file, write_text
from cnnsim.support.toml_file import KeyFaults, parse_toml, read_toml, take, take_numbers
from tactile.calibration.gains import Gains
from tactile.calibration.radial import RadialCorrection
from tactile.calibration.taxel_file import taxel_gains
from tactile.calibration.taxel_gains import TaxelGains
from tactile.core.file_kinds import refuse_other_kind

KEYS = ("shear_gain", "normal_gain", "depth_mm", "sigma", "radial")
GAIN_KEYS = ("shear_gain", "normal_gain", "depth_mm")
RADIAL_KEYS = ("located_um", "true_um", "force_factor")


@dataclass(frozen=True)
class Calibration:
    """The gains from readings to strain, the depth [m] to locate with, and the radial correction.

    ``sigma``: standard deviations of the shear gain, the normal gain and the depth [m], as far as they are known.
    """

    gains: Gains
    depth: float
    radial: RadialCorrection
    sigma: tuple[float, float, float] | None = None


def load_calibration(path: Path | str) -> Calibration | TaxelGains:
    """Return the calibration that a file holds: that of a scan, or the gains of every taxel from known loads.

    Raises:
        InputError: no such file, no TOML, an unknown or missing key, a wrong type or value.
    """
    return _calibration(read_toml(named_file(path), "calibration"), str(path))


def parse_calibration(text: str, where: str) -> Calibration | TaxelGains:
    """Return the calibration that a file's text is; ``where`` names it in messages.

    Raises:
        InputError: as ``load_calibration``.
    """
    return _calibration(parse_toml(text, where), where)


def _calibration(table: dict[str, Any], where: str) -> Calibration | TaxelGains:
    refuse_other_kind(table, where, "calibration")
    if "taxel" in table:
        return taxel_gains(table, where)
    faults = KeyFaults(where)
    faults.check(table, KEYS, "", (*GAIN_KEYS, "radial"))
    for name, keys in (("radial", RADIAL_KEYS), ("sigma", GAIN_KEYS)):
        if name in table:
            faults.check(table[name], keys, f"[{name}]", keys)
    faults.tell()
    radial = take(table, "radial", dict, where)
    count = len(take(radial, "located_um", list, f"{where}: [radial]"))
    columns = [take_numbers(radial, key, count, f"{where}: [radial]") for key in RADIAL_KEYS]
    depth = take(table, "depth_mm", float, where)
    if depth <= 0:
        raise InputError(f"{where}: depth_mm = {depth}, a positive number wanted")
    try:
        found, true = ([um * 1e-6 for um in column] for column in columns[:2])
        gains = Gains(take(table, "shear_gain", float, where), take(table, "normal_gain", float, where))
        return Calibration(gains, depth * 1e-3, RadialCorrection(found, true, columns[2]), _sigma(table, where))
    except InputError as error:
        raise error if str(error).startswith(where) else InputError(f"{where}: {error}") from error


def _sigma(table: dict[str, Any], where: str) -> tuple[float, float, float] | None:
    if "sigma" not in table:
        return None
    spread, where = take(table, "sigma", dict, where), f"{where}: [sigma]"
    shear, normal, depth = (take(spread, key, float, where) for key in GAIN_KEYS)
    if min(shear, normal, depth) < 0:
        raise InputError(f"{where}: {[shear, normal, depth]}, standard deviations of 0 or more wanted")
    return shear, normal, depth * 1e-3


def write_calibration(path: Path, made: Calibration) -> None:
    """Write a calibration, to be read by people as well.

    Raises:
        InputError: the file cannot be written.
    """
    radial, sigma = made.radial, []
    if made.sigma is not None:
        shear, normal, depth = made.sigma
        sigma = ["", "[sigma]", f"shear_gain = {shear!r}", f"normal_gain = {normal!r}", f"depth_mm = {depth * 1e3!r}"]
    lines = [
        "# Readings times the gains are strain; loads are located with this depth, then put right by their distance",
        "# from the taxel.",
        f"shear_gain = {made.gains.shear!r}",
        f"normal_gain = {made.gains.normal!r}",
        f"depth_mm = {made.depth * 1e3!r}",
        *sigma,
        "",
        "[radial]",
        f"located_um = {[radius * 1e6 for radius in radial.found]!r}",
        f"true_um = {[radius * 1e6 for radius in radial.true]!r}",
        f"force_factor = {list(radial.force)!r}",
    ]
    write_text(path, "\n".join(lines) + "\n")
