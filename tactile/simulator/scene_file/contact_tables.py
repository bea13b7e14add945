"""The tables [[contact]], [[texture]] and [[map]] of a scene file."""

from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from cnnsim.support import InputError, naming
from cnnsim.support.array_files import read_array
from cnnsim.support.error_list import read_all
from cnnsim.support.limits import one_line
from cnnsim.support.toml_file import (
    check_keys,
    line_of,
    located,
    take,
    take_choice,
    take_from_zero,
    take_numbers,
    take_positive,
)
from tactile.simulator.contacts.indenter import Indenter
from tactile.simulator.contacts.materials import PRESETS
from tactile.simulator.contacts.moving_contact import MovingContact
from tactile.simulator.contacts.shapes import LAWS, ROUND
from tactile.simulator.contacts.sliding_texture import SlidingTexture
from tactile.simulator.contacts.traction_map import TractionMap
from tactile.simulator.field import Contact
from tactile.simulator.scene_file.table_values import friction_of, keyframes, one_finger, take_seed

BY_FORCE = "t_s, x_mm, y_mm, Q_N, R_N, F_N"
BY_DEPTH = "t_s, x_mm, y_mm, Q_N, R_N, indentation_mm"
GIVEN = ("force", "indentation")


def read_contact(table: dict[str, Any], names: list[str], where: str, folder: Path) -> Contact:
    """Return a body pressed by force or by depth, with a twist in a seventh column where ``twist = true``.

    Raises:
        InputError: an unknown key or shape, a missing size, a wrong path.
    """
    if table.get("shape") == "height_map":
        return _height_map(table, names, where, folder)
    given, twisted, indenter, friction, finger, path = read_all(
        where,
        lambda: take_choice(table, "given", GIVEN, where, "force"),
        lambda: take(table, "twist", bool, where, False),
        lambda: _indenter(table, where),
        lambda: friction_of(table, where),
        lambda: one_finger(table, names, where),
        lambda: keyframes(table, columns_of(table), where),
        lambda: _check_fits(table, where),
    )[:-1]
    by_depth = given == "indentation"
    if not twisted:
        path = np.hstack([path, np.zeros((len(path), 1))])
    path = path * (1, 1e-3, 1e-3, 1, 1, 1e-3 if by_depth else 1, 1e-3)
    return MovingContact(finger, indenter, path, friction, by_depth)


def columns_of(table: dict[str, Any]) -> str:
    """Return the names of the columns of a contact's path."""
    twisted = table.get("twist") is True and table.get("shape") != "height_map"
    return (BY_DEPTH if table.get("given") == "indentation" else BY_FORCE) + ", M_Nmm" * twisted


def _check_fits(table: dict[str, Any], where: str) -> None:
    """Refuse keys that do not fit the shape of a contact."""
    shape = table.get("shape")
    for key in ("file", "pitch_mm", "unit_mm"):
        if key in table:
            raise InputError(f"{where}: {key} of a {shape}; shape = 'height_map' wanted{line_of(table, key)}")
    if table.get("twist") is True and shape not in ROUND:
        raise InputError(f"{where}: a twisted {shape}, one of {', '.join(ROUND)} wanted{line_of(table, 'twist')}")
    if table.get("given") == "indentation" and shape not in LAWS:
        wanted = f"one of {', '.join(LAWS)} wanted"
        raise InputError(f"{where}: an indentation given for a {shape}, {wanted}{line_of(table, 'given')}")


def _indenter(table: dict[str, Any], where: str) -> Indenter:
    shape, radius, length, angle = read_all(
        where,
        lambda: take(table, "shape", str, where),
        *(partial(take_from_zero, table, key, where, 0.0) for key in ("radius_mm", "length_mm")),
        lambda: take(table, "angle_deg", float, where, 0.0),
    )
    with located(table), naming(where):
        return Indenter(shape, radius * 1e-3, length * 1e-3, float(np.deg2rad(angle)))


def _height_map(table: dict[str, Any], names: list[str], where: str, folder: Path) -> Contact:
    """Return a body as a height map: an .npy file of heights, or an .stl file in its position on the cover, z up."""
    from tactile.simulator.contacts.height_map import HeightMap  # only where called for
    from tactile.simulator.contacts.heights import read_heights  # the same

    for key in ("radius_mm", "length_mm", "angle_deg", "twist"):
        if key in table:
            raise InputError(f"{where}: {key} of a height_map; file and pitch_mm wanted{line_of(table, key)}")
    given, pitch, unit, friction, path, file, finger = read_all(
        where,
        lambda: take_choice(table, "given", GIVEN, where, "force"),
        lambda: take_positive(table, "pitch_mm", where) * 1e-3,
        lambda: take_positive(table, "unit_mm", where, 1.0) * 1e-3,
        lambda: friction_of(table, where),
        lambda: keyframes(table, columns_of(table), where),
        lambda: take(table, "file", str, where),
        lambda: one_finger(table, names, where),
    )
    path = path * (1, 1e-3, 1e-3, 1, 1, 1e-3 if given == "indentation" else 1)
    with located(table), naming(where):
        return HeightMap(
            finger, read_heights(folder / file, pitch, unit), pitch, path, friction, given == "indentation"
        )


def read_texture(table: dict[str, Any], names: list[str], where: str, _folder: Path) -> Contact:
    """Return a textured object drawn over one point of the cover.

    Raises:
        InputError: an unknown key or material, a value out of range.
    """
    finger, (x, y), material, start, stop, speed, direction, force, stiffness, seed = read_all(
        where,
        lambda: one_finger(table, names, where),
        lambda: take_numbers(table, "place_mm", 2, where, [0.0, 0.0]),
        lambda: _material(table, where),
        lambda: take(table, "start_s", float, where, 0.0),
        lambda: take(table, "stop_s", float, where),
        lambda: take_from_zero(table, "speed_mm_s", where) * 1e-3,
        lambda: float(np.deg2rad(take(table, "direction_deg", float, where, 0.0))),
        lambda: take_from_zero(table, "force_N", where),
        lambda: take_positive(table, "stiffness_N_mm", where, 1.0) * 1e3,
        lambda: take_seed(table, where),
    )
    with located(table), naming(where):
        place = (x * 1e-3, y * 1e-3)
        return SlidingTexture(finger, place, PRESETS[material], start, stop, speed, direction, force, stiffness, seed)


def _material(table: dict[str, Any], where: str) -> str:
    material = take(table, "material", str, where)
    with located(table, "material"):
        check_keys({material: None}, tuple(PRESETS), f"{where}: material")
    return material


def read_map(table: dict[str, Any], names: list[str], where: str, folder: Path) -> Contact:
    """Return a traction map from an .npy file: (rows, cols) pressures or (rows, cols, 3) tractions [Pa].

    Raises:
        InputError: an unknown key, no such file, an array of another shape or not finite.
    """
    finger, file, pitch, (x, y), strength = read_all(
        where,
        lambda: one_finger(table, names, where),
        lambda: take(table, "file", str, where),
        lambda: take_positive(table, "pitch_mm", where) * 1e-3,
        lambda: [length * 1e-3 for length in take_numbers(table, "origin_mm", 2, where, [0.0, 0.0])],
        lambda: keyframes(table, "t_s, strength", where),
    )
    path = folder / file
    with located(table, "file"), naming(where):
        with one_line(path, "an array of tractions"):
            traction = np.asarray(read_array(path), dtype=np.float64)
        if traction.ndim == 2:
            traction = np.stack([np.zeros_like(traction), np.zeros_like(traction), traction], axis=-1)
        if traction.ndim != 3 or traction.shape[2] != 3 or not traction.size or not np.isfinite(traction).all():
            raise InputError(f"{path}: shape {traction.shape}, finite (rows, cols) or (rows, cols, 3) wanted")
    from tactile.elastic.sums.spectral import map_loads  # only where called for

    rows, cols = traction.shape[:2]
    first = x - (cols - 1) / 2 * pitch, y - (rows - 1) / 2 * pitch
    return TractionMap(finger, map_loads(traction, pitch, first), strength)


READERS: dict[str, Callable[[dict[str, Any], list[str], str, Path], Contact]] = {
    "contact": read_contact,
    "texture": read_texture,
    "map": read_map,
}
