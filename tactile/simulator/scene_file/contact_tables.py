"""The tables [[contact]], [[texture]] and [[map]] of a scene file."""

from collections.abc import Callable
from pathlib import Path
from typing import Any, cast

import numpy as np

from cnnsim.support import InputError, naming
from cnnsim.support.arrays.array_file import read_array
from cnnsim.support.bounds import one_line
from cnnsim.support.toml_file import check_keys, take, take_numbers
from tactile.simulator.contacts.indenter import ROUND, Indenter, ShapeName
from tactile.simulator.contacts.materials import PRESETS
from tactile.simulator.contacts.moving_contact import MovingContact
from tactile.simulator.contacts.sliding_texture import SlidingTexture
from tactile.simulator.contacts.traction_map import TractionMap
from tactile.simulator.field import Contact
from tactile.simulator.scene_file.table_values import keyframes, one_finger, positive

BY_FORCE = "t_s, x_mm, y_mm, Q_N, R_N, F_N"
BY_DEPTH = "t_s, x_mm, y_mm, Q_N, R_N, indentation_mm"


def read_contact(table: dict[str, Any], names: list[str], where: str, folder: Path) -> Contact:
    """An indenter, pressed by force or by depth, with a twist in a seventh column where ``twist = true``.

    Raises:
        InputError: an unknown key or shape, a missing size, a wrong path.
    """
    given = take(table, "given", str, where, "force")
    if given not in ("force", "indentation"):
        raise InputError(f"{where}: given = {given!r}, 'force' or 'indentation' wanted")
    if table.get("shape") == "height_map":
        return _height_map(table, names, where, folder, given == "indentation")
    for key in ("file", "pitch_mm", "unit_mm"):
        if key in table:
            raise InputError(f"{where}: {key} of a {table.get('shape')}; shape = 'height_map' wanted")
    twisted = table.get("twist", False)
    if not isinstance(twisted, bool):
        raise InputError(f"{where}: twist = {twisted!r}, true or false wanted")
    with naming(where):
        indenter = Indenter(
            cast(ShapeName, take(table, "shape", str, where)),
            take(table, "radius_mm", float, where, 0.0) * 1e-3,
            take(table, "length_mm", float, where, 0.0) * 1e-3,
            float(np.deg2rad(take(table, "angle_deg", float, where, 0.0))),
        )
    if twisted and indenter.shape not in ROUND:
        raise InputError(f"{where}: a twisted {indenter.shape}, one of {', '.join(ROUND)} wanted")
    by_depth = given == "indentation"
    if by_depth and indenter.shape not in ("sphere", "needle", "flat_punch"):
        raise InputError(f"{where}: an indentation given for a {indenter.shape}, a sphere, needle or flat_punch wanted")
    friction = take(table, "friction", float, where) if "friction" in table else None
    if friction is not None and friction < 0:
        raise InputError(f"{where}: friction = {friction}, a number from 0 up wanted")
    columns = (BY_DEPTH if by_depth else BY_FORCE) + (", M_Nmm" if twisted else "")
    path = keyframes(table, columns, where)
    if not twisted:
        path = np.hstack([path, np.zeros((len(path), 1))])
    path = path * (1, 1e-3, 1e-3, 1, 1, 1e-3 if by_depth else 1, 1e-3)
    return MovingContact(one_finger(table, names, where), indenter, path, friction, by_depth)


def _height_map(table: dict[str, Any], names: list[str], where: str, folder: Path, by_depth: bool) -> Contact:
    """A body as a height map: an .npy file of heights, or an .stl file, lying as it does on the cover, z up."""
    from tactile.simulator.contacts.height_map import HeightMap  # only where called for
    from tactile.simulator.contacts.heights import read_heights  # the same

    for key in ("radius_mm", "length_mm", "angle_deg", "twist"):
        if key in table:
            raise InputError(f"{where}: {key} of a height_map; file and pitch_mm wanted")
    pitch, unit = positive(table, "pitch_mm", where) * 1e-3, positive(table, "unit_mm", where, 1.0) * 1e-3
    friction = take(table, "friction", float, where) if "friction" in table else None
    if friction is not None and friction < 0:
        raise InputError(f"{where}: friction = {friction}, a number from 0 up wanted")
    path = keyframes(table, BY_DEPTH if by_depth else BY_FORCE, where)
    path = path * (1, 1e-3, 1e-3, 1, 1, 1e-3 if by_depth else 1)
    with naming(where):
        heights = read_heights(folder / take(table, "file", str, where), pitch, unit)
        return HeightMap(one_finger(table, names, where), heights, pitch, path, friction, by_depth)


def read_texture(table: dict[str, Any], names: list[str], where: str, _folder: Path) -> Contact:
    """A textured object drawn over one point of the cover.

    Raises:
        InputError: an unknown key or material, a value out of range.
    """
    material = take(table, "material", str, where)
    check_keys({material: None}, tuple(PRESETS), f"{where}: material")
    x, y = take_numbers(table, "place_mm", 2, where, [0.0, 0.0])
    try:
        return SlidingTexture(
            one_finger(table, names, where),
            (x * 1e-3, y * 1e-3),
            PRESETS[material],
            take(table, "start_s", float, where, 0.0),
            take(table, "stop_s", float, where),
            take(table, "speed_mm_s", float, where) * 1e-3,
            float(np.deg2rad(take(table, "direction_deg", float, where, 0.0))),
            take(table, "force_N", float, where),
            positive(table, "stiffness_N_mm", where, 1.0) * 1e3,
            take(table, "seed", int, where, 0),
        )
    except InputError as error:
        raise error if str(error).startswith(where) else InputError(f"{where}: {error}") from error


def read_map(table: dict[str, Any], names: list[str], where: str, folder: Path) -> Contact:
    """A traction map from an .npy file beside the scene: (rows, cols) pressures or (rows, cols, 3) tractions [Pa].

    Raises:
        InputError: an unknown key, no such file, an array of another shape or not finite.
    """
    path = folder / take(table, "file", str, where)
    try:
        with one_line(path, "an array of tractions"):
            traction = np.asarray(read_array(path), dtype=np.float64)
    except InputError as error:
        raise InputError(f"{where}: {error}") from error
    if traction.ndim == 2:
        traction = np.stack([np.zeros_like(traction), np.zeros_like(traction), traction], axis=-1)
    if traction.ndim != 3 or traction.shape[2] != 3 or not traction.size or not np.isfinite(traction).all():
        raise InputError(f"{where}: {path}: shape {traction.shape}, finite (rows, cols) or (rows, cols, 3) wanted")
    from tactile.elastic.sums.spectral import map_loads  # only where called for

    pitch = positive(table, "pitch_mm", where) * 1e-3
    x, y = (length * 1e-3 for length in take_numbers(table, "origin_mm", 2, where, [0.0, 0.0]))
    rows, cols = traction.shape[:2]
    first = x - (cols - 1) / 2 * pitch, y - (rows - 1) / 2 * pitch
    strength = keyframes(table, "t_s, strength", where)
    return TractionMap(one_finger(table, names, where), map_loads(traction, pitch, first), strength)


READERS: dict[str, Callable[[dict[str, Any], list[str], str, Path], Contact]] = {
    "contact": read_contact,
    "texture": read_texture,
    "map": read_map,
}
