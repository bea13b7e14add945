"""Reader of template files: TOML to a library entry, with all checks. templates/README.md describes the keys."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

from cnnsim.library.entry import Example, LibraryEntry, Role
from cnnsim.library.read_network import TEMPLATE_KEYS, needed_keys, parse_pictures, read_template
from cnnsim.network import LayeredTemplate, parse_boundary
from cnnsim.network.characteristic import parse_cell
from cnnsim.solver.tolerance import read_accuracy
from cnnsim.support import Floats, InputError, naming
from cnnsim.support.error_list import ErrorList
from cnnsim.support.errors import shown
from cnnsim.support.files import check_name
from cnnsim.support.toml_file import (
    line_of,
    read_toml,
    take,
    take_duration,
    take_from_zero,
    take_positive,
    take_tables,
)

Table = dict[str, Any]
_REQUIRED = ("name", "summary", "reference", "input", "initial_state", "boundary", "duration")
_OPTIONAL = ("tags", "margin", "note", "aliases", "example", "cell", "step", "frame_time", "accuracy", *TEMPLATE_KEYS)
_PLANES = ("input", "state", "output", "mask", "bias")


def load_file(path: Path) -> LibraryEntry:
    """Read and check a template file; a worked example is required in the shipped library only.

    Raises:
        InputError: all errors of the file, with their lines.
    """
    data = read_toml(path, "template file")
    errors = ErrorList(str(path))
    found = _fields(data, path.stem, errors)
    errors.raise_all()
    with naming(path):
        entry = LibraryEntry(**found, file=path)
        _check_whole(data, entry)
        if entry.shipped and not entry.examples:
            raise InputError("no worked example; at least one [[example]] wanted")
        return entry


def _fields(data: Table, stem: str, errors: ErrorList) -> dict[str, Any]:
    """Return the fields of the entry of a file."""
    errors.check(data, (*_REQUIRED, *_OPTIONAL), required=(*_REQUIRED, *needed_keys(data)))
    found: dict[str, Any] = {}
    for key, read in _READERS.items():
        if key in data:
            with errors.collecting(data, key):
                found[key] = read(data, key, "template")
    name = found.get("name", stem)
    with errors.collecting(data, "name"):
        if name != stem:
            raise InputError(f"the name is {name!r}, the file is {stem}.toml; one name wanted")
    with errors.collecting():
        found["examples"] = tuple(_example(item, errors) for item in take_tables(data, "example", "template"))
    return found | {"network": read_template(data, name, errors)}


def _check_whole(data: Table, entry: LibraryEntry) -> None:
    """Check combinations of keys."""
    template, roles = entry.network, entry.initial_state
    if template.reads_input and entry.input == "none":
        raise InputError(f"B is not zero, or a term reads u, but input is 'none'{line_of(data, 'input')}")
    if isinstance(roles, tuple) and not (isinstance(template, LayeredTemplate) and len(roles) == len(template.layers)):
        raise InputError(f"{len(roles)} initial states; one, or one a layer, wanted{line_of(data, 'initial_state')}")


def _name(table: Table, key: str, where: str) -> str:
    return check_name(take(table, key, str, where), where)


def _text(table: Table, key: str, where: str) -> str:
    return take(table, key, str, where)


def _texts(table: Table, key: str, where: str) -> tuple[str, ...]:
    found = take(table, key, list, where)
    if not all(isinstance(word, str) for word in found):
        raise InputError(f"{where}: {key} = {shown(found)}, a list of texts wanted")
    return tuple(found)


def _initial_state(table: Table, key: str, _where: str) -> Role | tuple[Role, ...]:
    roles = table[key]
    return tuple(map(_state, roles)) if isinstance(roles, list) else _state(roles)


def _state(value: Any) -> Role:
    return _role("initial_state", value, ("picture", "given", "any"))


def _role(key: str, value: Any, words: tuple[str, ...]) -> Role:
    if value in words or (isinstance(value, int | float) and not isinstance(value, bool) and abs(value) <= 1):
        return value
    raise InputError(f"{key} is {shown(value)}; one of {', '.join(map(repr, words))} or a number from -1 to 1 wanted")


def _example(table: Table, errors: ErrorList) -> Example | None:
    before = len(errors)
    errors.check(table, (*_PLANES, "tolerance"), required=("output",))
    planes: dict[str, Floats | None] = dict.fromkeys(_PLANES)
    for key in _PLANES:
        if key in table:
            with errors.collecting(table, key, f"example: {key}"):
                planes[key] = parse_pictures(table[key])
    with errors.collecting(table):
        tolerance = take_from_zero(table, "tolerance", "example") if "tolerance" in table else None
        if len(errors) > before:
            return None
        if planes["input"] is None and planes["state"] is None:
            raise InputError("an example without input and without state; at least one of them wanted")
        shapes = {key: plane.shape[-2:] for key, plane in planes.items() if plane is not None}
        if len(set(shapes.values())) > 1:
            raise InputError(f"an example's planes have different shapes: {shapes}")
        return Example(**planes, tolerance=tolerance)  # type: ignore[arg-type]  # output is required above
    return None


_READERS: dict[str, Callable[[Table, str, str], Any]] = {
    "name": _name,
    "summary": _text,
    "reference": _text,
    "input": lambda table, key, _where: _role(key, table[key], ("picture", "none")),
    "initial_state": _initial_state,
    "boundary": lambda table, key, _where: parse_boundary(table[key]),
    "duration": lambda table, _key, where: take_duration(table, where),
    "tags": _texts,
    "margin": take_from_zero,
    "note": _text,
    "aliases": _texts,
    "cell": lambda table, key, _where: parse_cell(table[key]),
    "step": take_positive,
    "frame_time": take_positive,
    "accuracy": lambda table, _key, where: read_accuracy(table, where),
}
"""Reader of each key that is a field of a library entry."""
