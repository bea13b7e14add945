"""Writes a imported as a template file of our library (TOML)."""

import json
from collections.abc import Iterator, Mapping
from typing import Any

from cnnsim.library.imported import Imported
from cnnsim.library.write_terms import template_keys
from cnnsim.network.boundary import Boundary
from cnnsim.support.errors import InputError
from cnnsim.support.numbers import written

_TABLES = ("layer", "term")


def template_file(imported: Imported) -> str:
    """Return the text of a template file.

    Raises:
        InputError: the imported says that it is not to be written.
    """
    if imported.missing:
        raise InputError(f"template {imported.name!r}: {imported.missing}")
    keys = template_keys(imported.template)
    data: dict[str, Any] = {
        "name": imported.name,
        "summary": imported.summary,
        "reference": imported.reference,
        "tags": list(imported.tags) or None,
        **{key: value for key, value in keys.items() if key not in _TABLES},
        "input": imported.input,
        "initial_state": imported.initial_state,
        "boundary": _boundary(imported.boundary),
        "duration": imported.duration,
        "cell": "discrete-time" if imported.discrete else None,
        "note": imported.note or None,
        "aliases": list(imported.aliases) or None,
        **{key: keys[key] for key in _TABLES if key in keys},
    }
    return "\n".join(_lines(data, "")) + "\n"


def _lines(data: Mapping[str, Any], parent: str) -> Iterator[str]:
    """Yield the lines of a table; lists of tables are its last keys."""
    for key, value in data.items():
        if key in _TABLES and isinstance(value, list):  # the layer of a term is a number
            for table in value:
                yield from ("", f"[[{parent}{key}]]")
                yield from _lines(table, f"{key}.")
        elif value is not None:
            yield f"{key} = {toml_value(value)}"


def _boundary(boundary: Boundary) -> Any:
    if boundary.kind != "fixed":
        return boundary.kind
    return {"fixed": boundary.y if boundary.y == boundary.u else {"x": boundary.y, "u": boundary.u}}


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
