"""Writer of template files (TOML): the reverse of `cnnsim.library.read`."""

import json
from collections.abc import Iterator, Mapping
from dataclasses import MISSING, fields
from typing import Any

import numpy as np

from cnnsim.formats.numbers import written
from cnnsim.library.entry import Example, LibraryEntry
from cnnsim.network import CHUA_YANG, AnyTemplate, Argument, LayeredTemplate, Table, Template, Term
from cnnsim.network.boundary import boundary_value
from cnnsim.network.characteristic import cell_value
from cnnsim.network.table import table_value
from cnnsim.support import Floats
from cnnsim.support.pictures.picture import to_ascii

_TABLES = ("layer", "term")


def template_text(entry: LibraryEntry) -> str:
    """Return the text of a template file that is read as the same entry."""
    keys = template_keys(entry.network)
    data: dict[str, Any] = {
        "name": entry.name,
        "summary": entry.summary,
        "reference": entry.reference,
        "tags": entry.tags or None,
        **{key: value for key, value in keys.items() if key not in _TABLES},
        "input": entry.input,
        "initial_state": entry.initial_state,
        "boundary": boundary_value(entry.boundary),
        "duration": entry.duration,
        "cell": None if entry.cell == CHUA_YANG else cell_value(entry.cell),
        "step": entry.step,
        "frame_time": entry.frame_time,
        "accuracy": entry.accuracy,
        "margin": entry.margin,
        "note": entry.note or None,
        "aliases": entry.aliases or None,
        **{key: keys[key] for key in _TABLES if key in keys},
    }
    examples = (line for example in entry.examples for line in _example(example))
    return "\n".join([*_lines(data, ""), *examples]) + "\n"


def _lines(data: Mapping[str, Any], parent: str) -> Iterator[str]:
    """Yield the lines of a table; lists of tables are its last keys."""
    for key, value in data.items():
        if key in _TABLES and isinstance(value, list):  # the layer of a term is a number
            for table in value:
                yield from ("", f"[[{parent}{key}]]")
                yield from _lines(table, f"{key}.")
        elif value is not None:
            yield f"{key} = {toml_value(value)}"


def _example(example: Example) -> Iterator[str]:
    """Yield the lines of an example, its pictures drawn row by row."""
    yield from ("", "[[example]]")
    for key in ("input", "state", "mask", "bias", "output"):
        if (plane := getattr(example, key)) is not None:
            yield from (f"{key} = [", *(f"  {toml_value(row)}," for row in _rows(plane)), "]")
    if example.tolerance is not None:
        yield f"tolerance = {toml_value(example.tolerance)}"


def _rows(plane: Floats) -> list[Any]:
    """Return a picture as text if it is black and white, else as numbers; several planes as a list."""
    if plane.ndim > 2:
        return [_rows(one) for one in plane]
    return to_ascii(plane) if np.isin(plane, (-1, 1)).all() else plane.tolist()


def toml_value(value: Any) -> str:
    """Return a value as TOML writes it on one line."""
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, int | float):
        return written(value)
    if isinstance(value, str):
        return _string(value)
    if isinstance(value, Mapping):
        return "{ " + ", ".join(f"{key} = {toml_value(item)}" for key, item in value.items()) + " }"
    return "[" + ", ".join(map(toml_value, value)) + "]"


def _string(text: str) -> str:
    """Return a TOML basic string: JSON's escapes, and DEL, which JSON leaves alone and TOML forbids."""
    text = text.encode("utf-8", "replace").decode("utf-8")  # half of a surrogate pair cannot be written
    return json.dumps(text, ensure_ascii=False).replace("\x7f", "\\u007F")


def template_keys(template: AnyTemplate) -> dict[str, Any]:
    """Return the keys of a template file that define the template: A, B, z, [[term]] and [[layer]] tables."""
    if not isinstance(template, LayeredTemplate):
        return _single_layer(template)
    layers = []
    for layer, time in zip(template.layers, template.time_constants, strict=True):
        numbers = _single_layer(layer)
        terms = numbers.pop("term", None)  # tables are last
        layers.append(numbers | ({} if time == 1 else {"time_constant": time}) | ({"term": terms} if terms else {}))
    return {"layer": layers}


def _single_layer(template: Template) -> dict[str, Any]:
    data: dict[str, Any] = {"A": template.A.tolist()}
    if template.control_taps:
        data["B"] = template.B.tolist()
    data["z"] = template.z
    if template.terms:
        data["term"] = [_term(term) for term in template.terms]
    return data


def _term(term: Term) -> dict[str, Any]:
    """Return the fields of a term that differ from their defaults."""
    values = ((part, getattr(term, part.name)) for part in fields(term))
    return {part.name: _plain(v) for part, v in values if part.default is MISSING or v != part.default}


def _plain(value: Any) -> Any:
    match value:
        case np.ndarray():
            return value.tolist()
        case Table():
            return table_value(value)
        case Argument():
            return str(value)
    return value
