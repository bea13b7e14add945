"""The keys of a template file that say what the template is: A, B, z, ``[[term]]`` and ``[[layer]]`` tables."""

from dataclasses import MISSING, fields
from typing import Any

import numpy as np

from cnnsim.network import AnyTemplate, Argument, LayeredTemplate, Table, Template, Term
from cnnsim.network.table import table_value


def template_keys(template: AnyTemplate) -> dict[str, Any]:
    """Return the keys and values; lists of tables are for ``[[...]]``."""
    if not isinstance(template, LayeredTemplate):
        return _single_layer(template)
    layers = []
    for layer, time in zip(template.layers, template.time_constants, strict=True):
        numbers = _single_layer(layer)
        terms = numbers.pop("term", None)  # tables come after all plain keys
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
    """Return what a term is made of, under the names it has in `Term`, defaults left out."""
    values = ((part, getattr(term, part.name)) for part in fields(term))
    return {part.name: _value(v) for part, v in values if part.default is MISSING or v != part.default}


def _value(value: Any) -> Any:
    match value:
        case np.ndarray():
            return value.tolist()
        case Table():
            return table_value(value)
        case Argument():
            return str(value)
    return value
