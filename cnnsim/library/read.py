"""Reads a template file: the whole of it, checked, as an entry of the library. Its keys: templates/README.md."""

from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Any

from cnnsim.accuracy.wanted import read_accuracy
from cnnsim.library.entry import Example, LibraryEntry, Role
from cnnsim.library.read_network import TEMPLATE_KEYS, needed_keys, parse_pictures, read_template
from cnnsim.network import LayeredTemplate, parse_boundary
from cnnsim.network.characteristic import parse_cell
from cnnsim.support import Floats, InputError, naming
from cnnsim.support.error_list import ErrorList
from cnnsim.support.errors import shown
from cnnsim.support.files import check_name
from cnnsim.support.toml_file import (
    line_of,
    located,
    read_toml,
    take,
    take_duration,
    take_from_zero,
    take_positive,
    take_tables,
)

_REQUIRED = ("name", "summary", "reference", "input", "initial_state", "boundary", "duration")
_OPTIONAL = ("tags", "margin", "note", "aliases", "example", "cell", "step", "frame_time", "accuracy", *TEMPLATE_KEYS)
_PLANES = ("input", "state", "output", "mask", "bias")


def load_file(path: Path) -> LibraryEntry:
    """Read and check one template file. A shipped one has a worked example; a user's own may do without.

    Raises:
        InputError: all that is wrong, with the file's name and the lines.
    """
    data = read_toml(path, "template file")
    faults = ErrorList(str(path))
    found = _found(data, path.stem, faults)
    faults.raise_all()
    with naming(path):
        entry = LibraryEntry(**found, file=path)
        _check_whole(data, entry)
        if entry.shipped and not entry.examples:
            raise InputError("no worked example; at least one [[example]] wanted")
        return entry


def _found(data: dict[str, Any], stem: str, faults: ErrorList) -> dict[str, Any]:
    """Return what a file says as the fields of an entry; ``faults`` get what is missing, unknown and wrong."""
    faults.check(data, (*_REQUIRED, *_OPTIONAL), required=(*_REQUIRED, *needed_keys(data)))
    found: dict[str, Any] = {}
    for key, read in _READERS.items():
        if key in data:
            with faults.collecting(), located(data, key):
                found[key] = read(data)
    name = found.get("name", stem)
    if name != stem:
        with faults.collecting(), located(data, "name"):
            raise InputError(f"the name is {name!r}, the file is {stem}.toml; one name wanted")
    with faults.collecting():
        found["examples"] = tuple(_example(item, faults) for item in take_tables(data, "example", "template"))
    return found | {"network": read_template(data, name, faults)}


def _check_whole(data: dict[str, Any], entry: LibraryEntry) -> None:
    """Check what only holds between keys."""
    template, roles = entry.network, entry.initial_state
    if template.reads_input and entry.input == "none":
        raise InputError(f"B is not zero, or a term reads u, but input is 'none'{line_of(data, 'input')}")
    if isinstance(roles, tuple) and not (isinstance(template, LayeredTemplate) and len(roles) == len(template.layers)):
        raise InputError(f"{len(roles)} initial states; one, or one a layer, wanted{line_of(data, 'initial_state')}")


def _name(data: dict[str, Any]) -> str:
    return check_name(take(data, "name", str, "template"), "template")


def _initial_state(data: dict[str, Any]) -> Role | tuple[Role, ...]:
    roles = data["initial_state"]
    return tuple(map(_state, roles)) if isinstance(roles, list) else _state(roles)


def _text(key: str, data: dict[str, Any]) -> str:
    return take(data, key, str, "template")


def _positive(key: str, data: dict[str, Any]) -> float:
    return take_positive(data, key, "template")


def _from_zero(key: str, data: dict[str, Any]) -> float:
    return take_from_zero(data, key, "template")


def _words(key: str, data: dict[str, Any]) -> tuple[str, ...]:
    found = take(data, key, list, "template")
    if not all(isinstance(word, str) for word in found):
        raise InputError(f"template: {key} = {shown(found)}, a list of texts wanted")
    return tuple(found)


def _state(value: Any) -> Role:
    return _role("initial_state", value, ("picture", "given", "any"))


def _role(key: str, value: Any, words: tuple[str, ...]) -> Role:
    if value in words or (isinstance(value, int | float) and not isinstance(value, bool) and abs(value) <= 1):
        return value
    raise InputError(f"{key} is {shown(value)}; one of {', '.join(map(repr, words))} or a number from -1 to 1 wanted")


def _example(data: dict[str, Any], faults: ErrorList) -> Example | None:
    before = len(faults)
    faults.check(data, (*_PLANES, "tolerance"), required=("output",))
    planes: dict[str, Floats | None] = dict.fromkeys(_PLANES)
    for key in _PLANES:
        if key in data:
            with faults.collecting(), located(data, key), naming(f"example: {key}"):
                planes[key] = parse_pictures(data[key])
    tolerance = None
    with faults.collecting(), located(data):
        tolerance = take_from_zero(data, "tolerance", "example") if "tolerance" in data else None
        if len(faults) > before:
            return None
        if planes["input"] is None and planes["state"] is None:
            raise InputError("an example without input and without state; at least one of them wanted")
        shapes = {key: plane.shape[-2:] for key, plane in planes.items() if plane is not None}
        if len(set(shapes.values())) > 1:
            raise InputError(f"an example's planes have different shapes: {shapes}")
        return Example(**planes, tolerance=tolerance)  # type: ignore[arg-type]  # output is required above
    return None


_READERS: dict[str, Callable[[dict[str, Any]], Any]] = {
    "name": _name,
    "summary": partial(_text, "summary"),
    "reference": partial(_text, "reference"),
    "input": lambda data: _role("input", data["input"], ("picture", "none")),
    "initial_state": _initial_state,
    "boundary": lambda data: parse_boundary(data["boundary"]),
    "duration": lambda data: take_duration(data, "template"),
    "tags": partial(_words, "tags"),
    "margin": partial(_from_zero, "margin"),
    "note": partial(_text, "note"),
    "aliases": partial(_words, "aliases"),
    "cell": lambda data: parse_cell(data["cell"]),
    "step": partial(_positive, "step"),
    "frame_time": partial(_positive, "frame_time"),
    "accuracy": lambda data: read_accuracy(data, "template"),
}
"""Key of a file, which is a field of an entry, and what reads its value where it is there."""
