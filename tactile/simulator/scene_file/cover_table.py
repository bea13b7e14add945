"""The keys of a scene's [cover] that make it one of bumps."""

from collections.abc import Iterable
from typing import Any

from cnnsim.support import InputError
from cnnsim.support.toml_file import take, take_positive
from tactile.bump.shape import Shape
from tactile.core.frame import TaxelArray
from tactile.simulator.bump_cover import Bumps


def read_bumps(table: dict[str, Any], arrays: Iterable[TaxelArray], where: str) -> Bumps:
    """Bumps over all taxels; missing keys have the values of the paper.

    Raises:
        InputError: a wrong type or value, a strain that is neither "small" nor "finite", taxels below the body.
    """
    strain = take(table, "strain", str, where, "small")
    if strain not in ("small", "finite"):
        raise InputError(f"{where}: strain = {strain!r}, 'small' or 'finite' wanted")
    if strain == "small" and "indentation_mm" in table:
        raise InputError(f"{where}: an indentation_mm without strain = 'finite'; both wanted, or no indentation")
    if strain == "finite" and "contact_mm" in table:
        raise InputError(
            f"{where}: a contact_mm with strain = 'finite'; none wanted, because the contact grows with the indentation"
        )
    diameter = take_positive(table, "diameter_mm", where, 0.4) * 1e-3
    radius = diameter / 2
    thickness = take_positive(table, "thickness_mm", where, 2.0) * 1e-3
    try:
        bumps = Bumps(
            Shape(
                radius,
                thickness,
                10 * radius,
                # a finite table begins with a narrow contact
                take_positive(table, "contact_mm", where, diameter * 1e3 / (4 if strain == "small" else 20)) * 1e-3,
                take_positive(table, "fillet_mm", where, diameter * 1e3 / 20) * 1e-3,
            ),
            take(table, "poissons_ratio", float, where, 0.499),
            take_positive(table, "indentation_mm", where, radius / 2 * 1e3) * 1e-3 if strain == "finite" else 0.0,
        )
    except InputError as error:
        raise error if str(error).startswith(where) else InputError(f"{where}: {error}") from error
    for array in arrays:
        if array.depth > thickness:
            said = f"{where}: taxels {array.depth * 1e3:g} mm deep under bumps on {thickness * 1e3:g} mm"
            raise InputError(f"{said}; a depth up to that wanted")
        if min(array.rows, array.cols, 2) > 1 and array.pitch < 2 * bumps.shape.foot:
            raise InputError(
                f"{where}: bumps {2e3 * bumps.shape.foot:.4g} mm wide at their foot, {array.pitch * 1e3:g} mm apart;"
                " a larger pitch wanted"
            )
    return bumps
