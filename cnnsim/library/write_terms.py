"""The keys of a template file that say what the template is: A, B, z, ``[[term]]`` and ``[[layer]]`` tables."""

from typing import Any

from cnnsim.network.layers import AnyTemplate, LayeredTemplate
from cnnsim.network.table import Table
from cnnsim.network.template import Template
from cnnsim.network.term import Term


def template_keys(template: AnyTemplate) -> dict[str, Any]:
    """Return the keys and values; lists of tables are for ``[[...]]``."""
    if not isinstance(template, LayeredTemplate):
        return _single(template)
    layers = []
    for layer, time in zip(template.layers, template.time_constants, strict=True):
        numbers = _single(layer)
        terms = numbers.pop("term", None)  # tables come after all plain keys
        layers.append(numbers | ({} if time == 1 else {"time_constant": time}) | ({"term": terms} if terms else {}))
    return {"layer": layers}


def _single(template: Template) -> dict[str, Any]:
    data: dict[str, Any] = {"A": template.A.tolist()}
    if template.control_taps:
        data["B"] = template.B.tolist()
    data["z"] = template.z
    if template.terms:
        data["term"] = [_term(term) for term in template.terms]
    return data


def _term(term: Term) -> dict[str, Any]:
    data: dict[str, Any] = {"weights": term.weights.tolist(), "of": str(term.of)}
    if term.table is not None:
        data["table"] = _table(term.table)
    if term.times is not None:
        data["times"] = str(term.times)
    if term.delay:
        data["delay"] = term.delay
    if term.layer is not None:
        data["layer"] = term.layer
    return data


def _table(table: Table) -> dict[str, Any]:
    if table.kind == "linear":
        return {"linear": [list(point) for point in zip(table.at, table.values, strict=True)]}
    step: dict[str, Any] = {"at": list(table.at), "values": list(table.values)}
    return {"step": step | ({"closed": "left"} if table.closed == "left" else {})}
