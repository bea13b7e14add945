"""All faults of a scene file, told at once: keys that are missing or unknown, and wrong values in every table."""

from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Any

from cnnsim.support import InputError
from cnnsim.support.toml_file import KeyFaults, take
from tactile.core.array_table import take_array
from tactile.simulator.effects import ORDER, read_effect
from tactile.simulator.scene.checks import WHERE
from tactile.simulator.scene_file.contact_tables import BY_DEPTH, BY_FORCE, READERS
from tactile.simulator.scene_file.keys import TABLES, check_scene_keys
from tactile.simulator.scene_file.table_values import keyframes, one_finger, positive, quantity_of

POSITIVE = ("rate_hz", "duration_s", "tolerance")
COLUMNS = {"load": BY_FORCE, "texture": "", "map": "t_s, strength"}


def tell_all(table: dict[str, Any], where: str, folder: Path, first: InputError) -> None:
    """Refuse a scene, of which ``first`` is the fault that was met first, with all that is wrong in it.

    Raises:
        InputError: all faults, each once.
    """
    faults = KeyFaults(where)

    def trying(read: Callable[[], Any]) -> None:
        with faults.collecting():
            read()

    trying(partial(check_scene_keys, table, where))
    for key in POSITIVE:
        if key in table:
            trying(partial(positive, table, key, where))
    for key, value in (("title", str), ("seed", int), ("accuracy", float)):
        if key in table:
            trying(partial(take, table, key, value, where))
    trying(partial(_where_computed, table, where))
    cover = table.get("cover")
    if isinstance(cover, dict):
        for key in ("youngs_modulus_mpa", "full_scale"):
            if key in cover:
                trying(partial(positive, cover, key, f"{where}: [cover]"))
        trying(partial(quantity_of, cover, f"{where}: [cover]"))
    names = [one["name"] for one in _tables(table, "finger") if isinstance(one.get("name"), str)]
    for number, one in enumerate(_tables(table, "finger"), 1):
        if set(TABLES["finger"][1]) <= one.keys():
            trying(partial(take_array, one, "mm", f"{where}: finger {number}", "strain"))
    for kind in ("load", *READERS):
        for number, one in enumerate(_tables(table, kind), 1):
            place = f"{where}: {kind} {number}"
            if "finger" in one:
                trying(partial(one_finger, one, names, place))
            if columns := _columns(kind, one):
                trying(partial(keyframes, one, columns, place))
            if kind in READERS and set(TABLES[kind][1]) <= one.keys():
                trying(partial(READERS[kind], one, names, place, folder))
    effects: dict[str, Any] = named if isinstance(named := table.get("effect"), dict) else {}
    for name in ORDER:
        if name in effects:
            trying(partial(_effect, effects, name, where))
    with faults.collecting():
        raise first
    faults.tell()


def _tables(table: dict[str, Any], key: str) -> list[dict[str, Any]]:
    found = table.get(key)
    return [one for one in found if isinstance(one, dict)] if isinstance(found, list) else []


def _columns(kind: str, one: dict[str, Any]) -> str:
    """Return what the columns of a path are; nothing where there is none."""
    if "path" not in one:
        return ""
    if kind != "contact":
        return COLUMNS[kind]
    return (BY_DEPTH if one.get("given") == "indentation" else BY_FORCE) + (
        ", M_Nmm" if one.get("twist") is True else ""
    )


def _where_computed(table: dict[str, Any], where: str) -> None:
    backend, dtype = table.get("backend", "cpu"), table.get("dtype", "float64")
    if (backend, dtype) not in WHERE:
        wanted = ", ".join(f"{backend} in {dtype}" for backend, dtype in WHERE)
        raise InputError(f"{where}: {backend} in {dtype}; one of {wanted} wanted")


def _effect(effects: dict[str, Any], name: str, where: str) -> Any:
    return read_effect(name, take(effects, name, dict, f"{where}: [effect]"), f"{where}: [effect.{name}]")
