"""Writes a draft as a template file of our library (TOML)."""

import json
from collections.abc import Mapping
from typing import Any

from cnnsim.errors import InputError
from cnnsim.formats.draft import Draft, plain
from cnnsim.formats.numbers import written
from cnnsim.grid import Boundary


def template_file(draft: Draft) -> str:
    """Return the text of a template file.

    Raises:
        InputError: the draft is of a kind that the files cannot hold.
    """
    if draft.missing:
        raise InputError(f"template {draft.name!r}: {draft.missing}")
    template = plain(draft.template, "a template file")
    data: dict[str, Any] = {
        "name": draft.name,
        "summary": draft.summary,
        "reference": draft.reference,
        "tags": list(draft.tags) or None,
        "A": template.A.tolist(),
        "B": template.B.tolist() if template.control_taps else None,
        "z": template.z,
        **{key: value for key, value in draft.other.items() if not isinstance(value, Mapping)},
        "input": draft.input,
        "initial_state": draft.initial_state,
        "boundary": _boundary(draft.boundary),
        "duration": draft.duration,
        "note": draft.note or None,
        "aliases": list(draft.aliases) or None,
    }
    lines = [f"{key} = {toml_value(value)}" for key, value in data.items() if value is not None]
    for key, value in draft.other.items():
        if isinstance(value, Mapping):
            lines += ["", f"[{key}]", *(f"{inner} = {toml_value(item)}" for inner, item in value.items())]
    return "\n".join(lines) + "\n"


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
