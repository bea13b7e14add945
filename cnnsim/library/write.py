"""Writes a draft as a template file of our library (TOML)."""

import json
from collections.abc import Iterator, Mapping
from typing import Any

from cnnsim.library.imported import Draft
from cnnsim.library.write_terms import template_keys
from cnnsim.network.boundary import Boundary
from cnnsim.support.errors import InputError
from cnnsim.support.numbers import written

_TABLES = ("layer", "term")


def template_file(draft: Draft) -> str:
    """Return the text of a template file.

    Raises:
        InputError: the draft says that it is not to be written.
    """
    if draft.missing:
        raise InputError(f"template {draft.name!r}: {draft.missing}")
    keys = template_keys(draft.template)
    data: dict[str, Any] = {
        "name": draft.name,
        "summary": draft.summary,
        "reference": draft.reference,
        "tags": list(draft.tags) or None,
        **{key: value for key, value in keys.items() if key not in _TABLES},
        "input": draft.input,
        "initial_state": draft.initial_state,
        "boundary": _boundary(draft.boundary),
        "duration": draft.duration,
        "cell": "discrete-time" if draft.discrete else None,
        "note": draft.note or None,
        "aliases": list(draft.aliases) or None,
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
