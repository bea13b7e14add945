"""Reads a template file: the whole of it, checked, as an entry of the library. Its keys: templates/README.md."""

from dataclasses import replace
from pathlib import Path
from typing import Any

from cnnsim.accuracy.wanted import read_accuracy
from cnnsim.library.entry import Example, LibraryEntry, Role
from cnnsim.library.read_network import TEMPLATE_KEYS, parse_pictures, read_template
from cnnsim.network import LayeredTemplate, parse_boundary
from cnnsim.network.characteristic import parse_cell
from cnnsim.support import Floats, InputError, naming
from cnnsim.support.errors import shown
from cnnsim.support.names import check_name
from cnnsim.support.toml_file import check_keys, line_of, located, read_toml, take, take_duration, take_tables

_REQUIRED = ("name", "summary", "reference", "input", "initial_state", "boundary", "duration")
_OPTIONAL = ("tags", "margin", "note", "aliases", "example", "cell", "step", "frame_time", "accuracy", *TEMPLATE_KEYS)
_PLANES = ("input", "state", "output", "mask", "bias")


def load_file(path: Path) -> LibraryEntry:
    """Read and check one template file. A shipped one has a worked example; a user's own may do without.

    Raises:
        InputError: what is wrong, with the file's name.
    """
    data = read_toml(path, "template file")
    with naming(path):
        entry = replace(_entry(data, path.stem), file=path)
        if entry.shipped and not entry.examples:
            raise InputError("no worked example; at least one [[example]] wanted")
        return entry


def _entry(data: dict[str, Any], stem: str) -> LibraryEntry:
    check_keys(data, (*_REQUIRED, *_OPTIONAL), required=_REQUIRED)
    with located(data, "name"):
        check_name(take(data, "name", str, "template"), "template")
    if data["name"] != stem:
        where = line_of(data, "name")
        raise InputError(f"the name is {data['name']!r}, the file is {stem}.toml; one name wanted{where}")
    template, roles = read_template(data, data["name"]), data["initial_state"]
    with located(data, "initial_state"):
        state = tuple(map(_state, roles)) if isinstance(roles, list) else _state(roles)
    with located(data, "input"):
        shown = _role("input", data["input"], ("picture", "none"))
    with located(data, "boundary"):
        boundary = parse_boundary(data["boundary"])
    with located(data, "cell"):
        cell = parse_cell(data.get("cell", "chua-yang"))
    entry = LibraryEntry(
        data["name"], take(data, "summary", str, "template"), take(data, "reference", str, "template"), template, shown,
        state, boundary, take_duration(data, "template"), _words(data, "tags"), _number(data, "margin"),
        take(data, "note", str, "template", ""), _words(data, "aliases"),
        tuple(_example(item) for item in take_tables(data, "example", "template")),
        cell=cell, step=_number(data, "step"),
        frame_time=_number(data, "frame_time"), accuracy=read_accuracy(data, "template"),
    )  # fmt: skip
    if template.reads_input and entry.input == "none":
        raise InputError(f"B is not zero, or a term reads u, but input is 'none'{line_of(data, 'input')}")
    if isinstance(roles, list) and not (isinstance(template, LayeredTemplate) and len(roles) == len(template.layers)):
        raise InputError(f"{len(roles)} initial states; one, or one a layer, wanted{line_of(data, 'initial_state')}")
    return entry


def _number(data: dict[str, Any], key: str) -> float | None:
    return take(data, key, float, "template") if key in data else None


def _words(data: dict[str, Any], key: str) -> tuple[str, ...]:
    found = take(data, key, list, "template", [])
    if not all(isinstance(word, str) for word in found):
        raise InputError(f"template: {key} = {shown(found)}, a list of texts wanted{line_of(data, key)}")
    return tuple(found)


def _picture(data: dict[str, Any], key: str) -> Floats:
    with located(data, key):
        return parse_pictures(data[key])


def _state(value: Any) -> Role:
    return _role("initial_state", value, ("picture", "given", "any"))


def _role(key: str, value: Any, words: tuple[str, ...]) -> Role:
    if value in words or (isinstance(value, int | float) and not isinstance(value, bool) and abs(value) <= 1):
        return value
    raise InputError(f"{key} is {shown(value)}; one of {', '.join(map(repr, words))} or a number from -1 to 1 wanted")


def _example(data: dict[str, Any]) -> Example:
    check_keys(data, (*_PLANES, "tolerance"), required=("output",))
    planes = {key: _picture(data, key) if key in data else None for key in _PLANES}
    if planes["input"] is None and planes["state"] is None:
        raise InputError(f"an example without input and without state; at least one of them wanted{line_of(data)}")
    shapes = {key: plane.shape[-2:] for key, plane in planes.items() if plane is not None}
    if len(set(shapes.values())) > 1:
        raise InputError(f"an example's planes have different shapes: {shapes}{line_of(data)}")
    tolerance = take(data, "tolerance", float, "example") if "tolerance" in data else None
    return Example(**planes, tolerance=tolerance)  # type: ignore[arg-type]  # output is required above
