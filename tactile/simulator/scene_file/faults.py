"""All faults of a scene file, told at once: keys that are missing or unknown, and wrong values in every table."""

from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Any

from cnnsim.support import InputError
from cnnsim.support.error_list import ErrorList
from cnnsim.support.toml_file import take, take_from_zero, take_positive
from tactile.core.array_table import take_array
from tactile.simulator.effects import ORDER, read_effect
from tactile.simulator.scene_file.contact_tables import READERS
from tactile.simulator.scene_file.keys import check_scene_keys
from tactile.simulator.scene_file.table_values import quantity_of, read_load, take_seed

POSITIVE = ("rate_hz", "duration_s", "tolerance")


def tell_all(table: dict[str, Any], where: str, folder: Path, first: InputError) -> None:
    """Refuse a scene, of which ``first`` is the fault that was met first, with all that is wrong in it.

    Raises:
        InputError: all faults, each once.
    """
    faults = ErrorList(where)

    def trying(read: Callable[[], Any]) -> None:
        with faults.collecting():
            read()

    check_scene_keys(table, faults)
    for key in POSITIVE:
        if key in table:
            trying(partial(take_positive, table, key, where))
    if "title" in table:
        trying(partial(take, table, "title", str, where))
    trying(partial(take_from_zero, table, "accuracy", where, 0.0))
    trying(partial(take_seed, table, where))
    cover = table.get("cover")
    if isinstance(cover, dict):
        for key in ("youngs_modulus_mpa", "full_scale"):
            if key in cover:
                trying(partial(take_positive, cover, key, f"{where}: [cover]"))
        trying(partial(quantity_of, cover, f"{where}: [cover]"))
    names = [one["name"] for one in _tables(table, "finger") if isinstance(one.get("name"), str)]
    for number, one in enumerate(_tables(table, "finger"), 1):
        trying(partial(take_array, one, "mm", f"{where}: finger {number}", "strain"))
    for number, one in enumerate(_tables(table, "load"), 1):
        trying(partial(read_load, one, names, f"{where}: load {number}"))
    for kind, reader in READERS.items():
        for number, one in enumerate(_tables(table, kind), 1):
            trying(partial(reader, one, names, f"{where}: {kind} {number}", folder))
    effects: dict[str, Any] = named if isinstance(named := table.get("effect"), dict) else {}
    for name in ORDER:
        if name in effects:
            trying(partial(_effect, effects, name, where))
    with faults.collecting():
        raise first
    faults.raise_all()


def _tables(table: dict[str, Any], key: str) -> list[dict[str, Any]]:
    found = table.get(key)
    return [one for one in found if isinstance(one, dict)] if isinstance(found, list) else []


def _effect(effects: dict[str, Any], name: str, where: str) -> Any:
    return read_effect(name, take(effects, name, dict, f"{where}: [effect]"), f"{where}: [effect.{name}]")
