"""Scenes in TOML files: examples/scenes/ explains every key. Lengths in mm there, SI units here."""

from pathlib import Path
from typing import Any

from cnnsim.support import InputError
from cnnsim.support.error_list import ErrorList
from cnnsim.support.limits import FRAMES, RATE, check_most
from cnnsim.support.toml_file import line_of, read_toml, take, take_positive, take_tables
from tactile.core.array_table import take_array
from tactile.core.file_kinds import refuse_other_kind
from tactile.core.frame import TaxelArray
from tactile.simulator.field import Contact
from tactile.simulator.scene.scene import FULL_SCALE, Scene
from tactile.simulator.scene_file.keys import check_scene_keys
from tactile.simulator.scene_file.table_values import quantity_of, read_load, take_seed
from tactile.simulator.summation import ACCURACY

TOLERANCE = 0.02
"""What ``effects = "auto"`` may leave out, relative to the peak of the signal, unless the scene says."""


def read_scene(path: Path) -> Scene:
    """Read a scene from a TOML file; ``examples/scenes/`` explains every key.

    Raises:
        InputError: no such file, no TOML, an unknown or missing key, a wrong type or value, nothing that presses.
    """
    return scene_from(scene_table(path), str(path), path.parent)


def scene_table(path: Path) -> dict[str, Any]:
    """Return the table of a scene file as it stands there, none of its keys looked at.

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
    """Return the scene that a parsed TOML table describes; ``where`` names it in messages, ``folder`` holds its files.

    With ``effects = "auto"`` the effects whose estimated size exceeds ``tolerance`` are on, see ``auto``.

    Raises:
        InputError: as ``read_scene``.
    """
    scene, tolerance = bare_scene(table, where, folder)
    if tolerance is None:
        return scene
    from tactile.simulator.auto_effects import choose  # only where called for

    return choose(scene, tolerance).scene


def bare_scene(table: dict[str, Any], where: str, folder: Path = Path()) -> tuple[Scene, float | None]:
    """The scene with the effects that it names, and the tolerance of ``effects = "auto"``, None without it.

    Raises:
        InputError: as ``read_scene``; all that is wrong at once.
    """
    try:
        return _scene(table, where, folder)
    except InputError as error:
        from tactile.simulator.scene_file.faults import tell_all  # only for a scene that is wrong

        tell_all(table, where, folder, error)
        raise


def _scene(table: dict[str, Any], where: str, folder: Path) -> tuple[Scene, float | None]:
    faults = ErrorList(where)
    check_scene_keys(table, faults)
    faults.raise_all()
    cover = take(table, "cover", dict, where)
    bumpy = _is_bumpy(cover, f"{where}: [cover]")
    modulus = take_positive(cover, "youngs_modulus_mpa", f"{where}: [cover]") * 1e6
    quantity = quantity_of(cover, f"{where}: [cover]")
    fingers = take_tables(table, "finger", where)
    arrays = tuple(_finger(finger, quantity, f"{where}: finger {n}") for n, finger in enumerate(fingers, 1))
    names = [array.name for array in arrays]
    if not names or len(set(names)) < len(names):
        raise InputError(f"{where}: fingers {names}, at least one [[finger]] and no name twice wanted")
    loads = tuple(
        read_load(load, names, f"{where}: load {n}") for n, load in enumerate(take_tables(table, "load", where), 1)
    )
    contacts = _contacts(table, names, where, folder)
    if not loads and not contacts:
        raise InputError(
            f"{where}: a scene without loads, at least one [[load]] wanted (or [[contact]], [[texture]], [[map]])"
        )
    rate, duration = take_positive(table, "rate_hz", where), take_positive(table, "duration_s", where)
    check_most(rate, RATE, f"{where}: rate_hz")
    check_most(rate * duration, FRAMES, f"{where}: frames, rate_hz times duration_s")
    bumps = None
    if bumpy:
        from tactile.simulator.scene_file.cover_table import read_bumps  # only where called for

        bumps = read_bumps(cover, arrays, f"{where}: [cover]")
    scene = Scene(
        title=take(table, "title", str, where),
        rate=rate,
        duration=duration,
        modulus=modulus,
        arrays=arrays,
        loads=loads,
        contacts=contacts,
        effects=_effects(table, where),
        full_scale=take_positive(cover, "full_scale", f"{where}: [cover]", FULL_SCALE),
        seed=take_seed(table, where),
        bumps=bumps,
        accuracy=take(table, "accuracy", float, where, ACCURACY),
    )
    if scene.bumps is not None:
        by_depth = [n for n, contact in enumerate(contacts, 1) if getattr(contact, "given_depth", False)]
        if by_depth:
            raise InputError(
                f"{where}: contact {by_depth[0]}: given = 'indentation' on bumps; 'force' wanted, for how far a shape "
                "sinks in is known of the flat cover only"
            )
        flat = [name for name, effect in scene.effects if effect.STAGE == "field"]
        if flat:
            raise InputError(
                f"{where}: [effect]: {', '.join(flat)} on bumps; effects on the flat cover's field left out wanted"
            )
    if "effects" not in table:
        if "tolerance" in table:
            raise InputError(f"{where}: a tolerance without effects = 'auto'")
        return scene, None
    if table["effects"] != "auto":
        raise InputError(
            f"{where}: effects = {table['effects']!r}, 'auto' wanted; single ones are tables [effect.NAME]"
        )
    return scene, take_positive(table, "tolerance", where, TOLERANCE)


def _is_bumpy(cover: dict[str, Any], where: str) -> bool:
    kind = take(cover, "kind", str, where, "flat")
    if kind not in ("flat", "bump"):
        raise InputError(f"{where}: kind = {kind!r}, 'flat' or 'bump' wanted{line_of(cover, 'kind')}")
    return kind == "bump"


def _finger(table: dict[str, Any], quantity: str, where: str) -> TaxelArray:
    return take_array(table, "mm", where, quantity)


def _contacts(table: dict[str, Any], names: list[str], where: str, folder: Path) -> tuple[Contact, ...]:
    if not any(table.get(kind) for kind in ("contact", "texture", "map")):
        return ()
    from tactile.simulator.scene_file import contact_tables as scene_contacts  # only where called for

    return tuple(
        read(entry, names, f"{where}: {kind} {n}", folder)
        for kind, read in scene_contacts.READERS.items()
        for n, entry in enumerate(take_tables(table, kind, where), 1)
    )


def _effects(table: dict[str, Any], where: str) -> tuple[tuple[str, Any], ...]:
    named = take(table, "effect", dict, where, {})
    if not named:
        return ()
    from tactile.simulator.effects import ORDER, read_effect  # only where called for

    return tuple(
        (name, read_effect(name, take(named, name, dict, f"{where}: [effect]"), f"{where}: [effect.{name}]"))
        for name in ORDER
        if name in named
    )
