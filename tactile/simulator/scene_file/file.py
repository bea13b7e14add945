"""Reader of scene files in TOML: ``examples/scenes/`` explains every key. Lengths are mm there, SI units here."""

from collections.abc import Callable, Mapping
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any, get_args

from cnnsim.support import InputError
from cnnsim.support.error_list import ErrorList
from cnnsim.support.limits import FRAMES, RATE, check_most
from cnnsim.support.toml_file import line_of, read_toml, take, take_choice, take_from_zero, take_positive, take_tables
from tactile.core.array_table import take_array
from tactile.core.file_kinds import refuse_other_kind
from tactile.core.frame import Quantity
from tactile.simulator.scene.scene import FULL_SCALE, Scene
from tactile.simulator.scene_file.keys import check_scene_keys
from tactile.simulator.scene_file.table_values import read_load, take_seed
from tactile.simulator.summation import ACCURACY

if TYPE_CHECKING:
    from tactile.simulator.bump_cover import Bumps

TOLERANCE = 0.02
"""Default tolerance of ``effects = "auto"``, relative to the peak of the ideal skin."""


def read_scene(path: Path) -> Scene:
    """Read a scene from a TOML file.

    Raises:
        InputError: no such file, no TOML, or all wrong keys and values of the file.
    """
    return scene_from(scene_table(path), str(path), path.parent)


def scene_table(path: Path) -> dict[str, Any]:
    """Return the table of a scene file, keys unchecked.

    Raises:
        InputError: no such file, no TOML, or another kind of file, such as a recording or an array description.
    """
    if path.is_file() and path.suffix.lower() != ".toml":
        raise InputError(
            f"{path}: suffix {path.suffix!r}, a scene (.toml) wanted; frames that are recorded have none"
            f" (`tactile run {path}` takes recordings)"
        )
    table = read_toml(path, "scene")
    refuse_other_kind(table, path, "scene")
    return table


def scene_from(table: dict[str, Any], where: str, folder: Path = Path()) -> Scene:
    """Return the scene of a parsed TOML table, with the effects that ``effects = "auto"`` chooses.

    Arguments: ``where`` names the scene in messages; ``folder`` contains the files that it reads.

    Raises:
        InputError: all wrong keys and values.
    """
    scene, tolerance = bare_scene(table, where, folder)
    if tolerance is None:
        return scene
    from tactile.simulator.auto_effects import choose  # only where called for

    return choose(scene, tolerance).scene


def bare_scene(table: dict[str, Any], where: str, folder: Path = Path()) -> tuple[Scene, float | None]:
    """Return the scene with all effects that it names, and the tolerance of ``effects = "auto"``, None without it.

    Raises:
        InputError: all wrong keys and values.
    """
    errors = ErrorList(where)

    def read(reader: Callable[..., Any], *given: Any) -> Any:
        """The value that a reader returns, None where it is wrong."""
        with errors.collecting():
            return reader(*given)

    check_scene_keys(table, errors)
    cover = read(take, table, "cover", dict, where) or {}
    of_cover = f"{where}: [cover]"
    modulus = read(take_positive, cover, "youngs_modulus_mpa", of_cover)
    quantity = read(take_choice, cover, "quantity", get_args(Quantity), of_cover, "strain")
    full_scale = read(take_positive, cover, "full_scale", of_cover, FULL_SCALE)
    bumpy = read(take_choice, cover, "kind", ("flat", "bump"), of_cover, "flat") == "bump"
    fingers = _tables(table, "finger", where, read)
    arrays = [read(take_array, one, "mm", place, quantity or "strain") for place, one in fingers]
    names = [str(one.get("name")) for _, one in fingers]
    with errors.collecting():
        if not names or len(set(names)) < len(names):
            raise InputError(f"{where}: fingers {names}, at least one [[finger]] and no name twice wanted")
    loads = [read(read_load, one, names, place) for place, one in _tables(table, "load", where, read)]
    contacts = _contacts(table, names, where, folder, read)
    effects = _effects(table, where, read)
    rate, duration = (read(take_positive, table, key, where) for key in ("rate_hz", "duration_s"))
    title, seed = read(take, table, "title", str, where), read(take_seed, table, where)
    accuracy = read(take_from_zero, table, "accuracy", where, ACCURACY)
    tolerance = read(_tolerance, table, where)
    errors.raise_all()
    bumps = _checked_bumps(cover, arrays, contacts, effects, where) if bumpy else None
    if not loads and not contacts:
        raise InputError(
            f"{where}: a scene without loads, at least one [[load]] wanted (or [[contact]], [[texture]], [[map]])"
        )
    check_most(rate, RATE, f"{where}: rate_hz")
    check_most(rate * duration, FRAMES, f"{where}: frames, rate_hz times duration_s")
    scene = Scene(
        title, rate, duration, modulus * 1e6, arrays, loads, contacts, effects, full_scale, seed, bumps, accuracy
    )
    return scene, tolerance


def _tables(table: dict[str, Any], key: str, where: str, read: Callable[..., Any]) -> list[tuple[str, dict[str, Any]]]:
    """The tables [[key]], each with its name in messages."""
    found = read(take_tables, table, key, where) or []
    return [(f"{where}: {key} {number}", one) for number, one in enumerate(found, 1)]


def _contacts(table: dict[str, Any], names: list[str], where: str, folder: Path, read: Callable[..., Any]) -> list[Any]:
    if not any(table.get(kind) for kind in ("contact", "texture", "map")):
        return []
    from tactile.simulator.scene_file.contact_tables import READERS  # only where called for

    return [
        read(reader, one, names, place, folder)
        for kind, reader in READERS.items()
        for place, one in _tables(table, kind, where, read)
    ]


def _effects(table: dict[str, Any], where: str, read: Callable[..., Any]) -> list[tuple[str, Any]]:
    named = read(take, table, "effect", dict, where, {})
    if not named:
        return []
    from tactile.simulator.effects import ORDER, read_effect  # only where called for

    return [
        (name, read(partial(read_effect, name), named[name], f"{where}: [effect.{name}]"))
        for name in ORDER
        if isinstance(named.get(name), Mapping)
    ]


def _tolerance(table: dict[str, Any], where: str) -> float | None:
    if "effects" not in table:
        if "tolerance" in table:
            raise InputError(f"{where}: a tolerance without effects = 'auto'; both wanted{line_of(table, 'tolerance')}")
        return None
    if table["effects"] != "auto":
        raise InputError(
            f"{where}: effects = {table['effects']!r}, 'auto' wanted; single ones are tables [effect.NAME]"
            f"{line_of(table, 'effects')}"
        )
    return take_positive(table, "tolerance", where, TOLERANCE)


def _checked_bumps(
    cover: dict[str, Any], arrays: list[Any], contacts: list[Any], effects: list[tuple[str, Any]], where: str
) -> "Bumps":
    from tactile.simulator.scene_file.cover_table import read_bumps  # only where called for

    by_depth = [n for n, contact in enumerate(contacts, 1) if getattr(contact, "given_depth", False)]
    if by_depth:
        raise InputError(
            f"{where}: contact {by_depth[0]}: given = 'indentation' on bumps; 'force' wanted, for the indentation of a "
            "shape is known of the flat cover only"
        )
    flat = [name for name, effect in effects if effect.STAGE == "field"]
    if flat:
        raise InputError(f"{where}: [effect]: {', '.join(flat)} on bumps; no effects on a flat cover's field wanted")
    return read_bumps(cover, arrays, f"{where}: [cover]")
