"""Reads and writes celnn's JSON: ``name``, ``feedback`` (A), ``control`` (B), ``bias``, ``description``, ``tags``.

A file holds one template, or ``{"templates": [...]}``. celnn correlates as we do, but maps black to -1 and white to +1;
under u, x, y -> -u, -x, -y the template (A, B, z) becomes (A, B, -z), so the **sign of z is turned** both ways.
Source: celnn 1.0.0, Template.to_dict.
"""

import json
from typing import Any

import numpy as np

from cnnsim.library.imported import Imported, assume_setting, library_name, plain
from cnnsim.network import AnyTemplate, Template
from cnnsim.support import Diagnostics, InputError

_KNOWN = {"name", "feedback", "control", "bias", "initial_state", "description", "tags", "metadata"}
_TURNED = "The sign of z is turned: black is -1 in celnn and +1 here."


def read_celnn(data: bytes, report: Diagnostics) -> list[Imported]:
    """Return the templates of a file; a wrong template is reported as an error and omitted."""
    try:
        content = json.loads(data, parse_constant=_no_constant)
    except (ValueError, RecursionError) as error:
        line = error.lineno if isinstance(error, json.JSONDecodeError) else None
        report.error(line, f"no JSON: {error}")
        return []
    items = content.get("templates") if isinstance(content, dict) and "templates" in content else [content]
    if not isinstance(items, list) or not items:
        report.error(None, "'templates' is no list of templates")
        return []
    templates = []
    for k, item in enumerate(items, start=1):
        try:
            templates.append(_imported(item, report))
        except (InputError, OverflowError) as error:
            report.error(None, f"template {k}: {error}")
    return templates


def _no_constant(word: str) -> float:
    raise ValueError(f"{word} is no number of JSON")


def _imported(item: Any, report: Diagnostics) -> Imported:
    if not isinstance(item, dict) or not {"name", "feedback", "control"} <= item.keys():
        raise InputError("'name', 'feedback' and 'control' wanted")
    title, tags, text = item["name"], item.get("tags", []), item.get("description", "")
    if not isinstance(title, str) or not isinstance(text, str):
        raise InputError("'name' and 'description' as text wanted")
    if not isinstance(tags, list) or not all(isinstance(tag, str) for tag in tags):
        raise InputError(f"tags {str(tags)[:40]}; a list of words wanted")
    bias = item.get("bias", 0.0)
    if isinstance(bias, bool) or not isinstance(bias, int | float):
        raise InputError(f"{title[:40]!r}: bias {str(bias)[:40]}; one number wanted, a bias map belongs to the task")
    name = library_name(title)
    template = Template(_numbers(item, "feedback"), _numbers(item, "control"), -float(bias) if bias else 0.0, name)
    for key in sorted(item.keys() - _KNOWN):
        report.warning(None, f"{name}: the key {key[:40]!r} is not known and not used")
    if item.get("initial_state") is not None:
        report.warning(None, f"{name}: its initial state is a plane of fixed size and not used")
    if bias:
        report.warning(None, f"{name}: {_TURNED}")
    summary = text or f"celnn template {title}; the source does not say what it does."
    reference = f"Imported from {report.file}, celnn template {title}"
    imported = Imported(name, summary, reference, template, tags=tuple(tags))
    imported = assume_setting(imported, report)
    return imported.with_note(_TURNED) if bias else imported


def _numbers(item: dict[str, Any], key: str) -> Any:
    """Return a matrix; JSON allows texts and truth values where NumPy would make numbers of them."""
    rows = item[key]
    good = isinstance(rows, list) and all(isinstance(row, list) for row in rows)
    if not good or any(isinstance(v, bool) or not isinstance(v, int | float) for row in rows for v in row):
        raise InputError(f"{key} is {str(rows)[:60]}; a matrix of numbers wanted")
    return rows


def celnn(template: AnyTemplate, summary: str, tags: tuple[str, ...]) -> str:
    """Return a template as celnn reads it, A and B in one shape, the sign of z turned.

    Raises:
        InputError: a template that is not linear.
    """
    template = plain(template, "celnn's JSON")
    side = max(template.A.shape[0], template.B.shape[0], 3)
    a, b = (np.pad(matrix, (side - len(matrix)) // 2).tolist() for matrix in (template.A, template.B))
    data = {
        "name": template.name, "feedback": a, "control": b, "bias": -template.z if template.z else 0.0,
        "initial_state": None, "description": summary, "tags": list(tags),
        "metadata": {"source": "exported for black = -1: the sign of the bias is turned"},
    }  # fmt: skip
    return json.dumps(data, indent=2, ensure_ascii=False) + "\n"
