"""Calibration file of a skin: the TOML that `calibrate` writes and `run` reads."""

from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any

from cnnsim.support import naming
from cnnsim.support.error_list import ErrorList, read_all
from cnnsim.support.files import named_file, write_text
from cnnsim.support.toml_file import located, parse_toml, read_toml, take, take_from_zero, take_numbers, take_positive
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

    ``sigma``: standard deviations of the shear gain, the normal gain and the depth [m], None if unknown.
    """

    gains: Gains
    depth: float
    radial: RadialCorrection
    sigma: tuple[float, float, float] | None = None


def load_calibration(path: Path | str) -> Calibration | TaxelGains:
    """Return the calibration of a file: from a scan, or the gains of every taxel from known loads.

    Raises:
        InputError: no such file, no TOML, an unknown or missing key, a wrong type or value.
    """
    return _calibration(read_toml(named_file(path), "calibration"), str(path))


def parse_calibration(text: str, where: str) -> Calibration | TaxelGains:
    """Return the calibration of a file's text; ``where`` names it in messages.

    Raises:
        InputError: as ``load_calibration``.
    """
    return _calibration(parse_toml(text, where), where)


def _calibration(table: dict[str, Any], where: str) -> Calibration | TaxelGains:
    refuse_other_kind(table, where, "calibration")
    if "taxel" in table:
        return taxel_gains(table, where)
    faults = ErrorList(where)
    faults.check(table, KEYS, "", (*GAIN_KEYS, "radial"))
    for name, keys in (("radial", RADIAL_KEYS), ("sigma", GAIN_KEYS)):
        if name in table:
            faults.check(table[name], keys, f"[{name}]", keys)
    with faults.collecting():
        shear, normal, depth, sigma, columns = read_all(
            where,
            lambda: take(table, "shear_gain", float, where),
            lambda: take(table, "normal_gain", float, where),
            lambda: take_positive(table, "depth_mm", where) * 1e-3,
            lambda: _sigma(table, where),
            lambda: _radial(take(table, "radial", dict, where), f"{where}: [radial]"),
        )
        with naming(where), located(table, "radial"):
            return Calibration(Gains(shear, normal), depth, RadialCorrection(*columns), sigma)
    faults.raise_all()
    raise AssertionError  # unreachable: the faults have been raised


def _radial(table: dict[str, Any], where: str) -> tuple[list[float], list[float], list[float]]:
    count = len(table["true_um"]) if isinstance(table.get("true_um"), list) else 0
    count = len(table["located_um"]) if isinstance(table.get("located_um"), list) else count
    found, true, factor = read_all(where, *(partial(take_numbers, table, key, count, where) for key in RADIAL_KEYS))
    return [um * 1e-6 for um in found], [um * 1e-6 for um in true], factor


def _sigma(table: dict[str, Any], where: str) -> tuple[float, float, float] | None:
    if "sigma" not in table:
        return None
    spread, where = take(table, "sigma", dict, where), f"{where}: [sigma]"
    shear, normal, depth = read_all(where, *(partial(take_from_zero, spread, key, where) for key in GAIN_KEYS))
    return shear, normal, depth * 1e-3


def write_calibration(path: Path, made: Calibration) -> None:
    """Write a calibration as TOML.

    Raises:
        InputError: the file cannot be written.
    """
    radial, sigma = made.radial, []
    if made.sigma is not None:
        shear, normal, depth = made.sigma
        sigma = ["", "[sigma]", f"shear_gain = {shear!r}", f"normal_gain = {normal!r}", f"depth_mm = {depth * 1e3!r}"]
    lines = [
        "# Readings times the gains are strain. Loads are located with this depth, and corrected by their distance",
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
