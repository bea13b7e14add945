"""Reader of the network of a template file: A, B, z, terms, layers; and of pictures in several planes.

A file has ``A``, ``B``, ``z`` and perhaps ``[[term]]`` tables, or ``[[layer]]`` tables that have them::

    [[term]]
    weights = [[...]]             # like A; the neighbour at offset (k, l)
    of      = "u_kl - u_ij"       # what the table is applied to: neighbour kl minus centre ij, or "y_kl"
    table   = { linear = [[-2, 2], [0, 0], [2, 2]] }        # or { step = { at = [0.2], values = [-1, 1] } }
    times   = "x_kl - x_ij"       # D type: a factor
    delay   = 10                  # time constants
    layer   = 0                   # whose neighbour, counted from 0; the own one if left out

Pictures of several planes (layers, or frames of a sequence) are lists of pictures.
"""

from dataclasses import fields
from typing import Any

import numpy as np

from cnnsim.network import AnyTemplate, LayeredTemplate, Template, Term
from cnnsim.network.table import parse_table
from cnnsim.support import Floats, InputError
from cnnsim.support.error_list import ErrorList
from cnnsim.support.errors import shown
from cnnsim.support.pictures.picture import parse_ascii
from cnnsim.support.toml_file import take_positive, take_tables

TEMPLATE_KEYS = ("A", "B", "z", "term", "layer")
_NEEDED = ("A", "z")
_LAYER_KEYS = ("A", "B", "z", "term", "time_constant")
_TERM_KEYS = tuple(part.name for part in fields(Term))


def needed_keys(data: dict[str, Any]) -> tuple[str, ...]:
    """Return the required keys of the network of a file."""
    return ("layer",) if "layer" in data else _NEEDED


def read_template(data: dict[str, Any], name: str, errors: ErrorList) -> AnyTemplate | None:
    """Return the template of a file; None if something is wrong, which is then in ``errors``."""
    if "layer" not in data:
        return _single_layer(data, name, errors, "")
    extra = {"A", "B", "z", "term"} & data.keys()
    with errors.collecting(data, min(extra, key=list(data).index) if extra else "layer"):
        if extra:
            raise InputError(f"layers and {', '.join(sorted(extra))}: with layers, each has its own A, B, z and terms")
        tables = take_tables(data, "layer", "template")
        for number, table in enumerate(tables):
            errors.check(table, _LAYER_KEYS, f"layer {number}", _NEEDED)
        layers = [_single_layer(table, f"{name}, layer {n}", errors, f"layer {n}: ") for n, table in enumerate(tables)]
        whole, times = [layer for layer in layers if layer is not None], list[float]()
        for number, table in enumerate(tables):
            with errors.collecting():
                times.append(take_positive(table, "time_constant", f"layer {number}", 1.0))
        if len(whole) == len(times) == len(tables):
            return LayeredTemplate(whole, times, name)
    return None


def _single_layer(data: dict[str, Any], name: str, errors: ErrorList, place: str) -> Template | None:
    """Return the template of one layer, whose keys have been checked, or None."""
    before = len(errors)
    tables: list[dict[str, Any]] = []
    with errors.collecting():
        tables = take_tables(data, "term", "template")
    terms = [_term(table, f"{place}term {number}", errors) for number, table in enumerate(tables)]
    for key in ("A", "B", "z"):
        with errors.collecting(data, key):  # a template with this key alone
            Template(**{"A": 0.0, key: data.get(key, 0.0)}, name=name)
    if len(errors) > before or not data.keys() >= set(_NEEDED):
        return None
    return Template(data["A"], data.get("B", 0.0), data["z"], name, [term for term in terms if term is not None])


def _term(table: dict[str, Any], place: str, errors: ErrorList) -> Term | None:
    before = len(errors)
    errors.check(table, _TERM_KEYS, place, ("weights",))
    values: dict[str, Any] = dict(table)
    if "table" in table:
        with errors.collecting(table, "table", place):
            values["table"] = parse_table(table["table"])
    for key in [key for key in _TERM_KEYS if key in values and key != "table"]:
        with errors.collecting(table, key, place):  # a term with this key alone, as above
            Term(**{"weights": 0.0, key: values[key]})
    return None if len(errors) > before else Term(**values)


def parse_pictures(value: Any) -> Floats:
    """Return one picture (rows, cols), or a list of pictures as (planes, rows, cols).

    Raises:
        InputError: no picture, or pictures of different size.
    """
    if not isinstance(value, list):
        raise InputError(f"a picture is {shown(value)}; a list of rows wanted")
    first = value[0] if value else None
    if not (isinstance(first, list) and first and isinstance(first[0], str | list)):
        return parse_ascii(value)
    if not all(isinstance(plane, list) for plane in value):
        raise InputError(f"{shown(value)}: a list of pictures, each a list of rows, wanted")
    planes = [parse_ascii(plane) for plane in value]
    if len({plane.shape for plane in planes}) > 1:
        raise InputError(f"pictures of different size in one list: {[plane.shape for plane in planes]}")
    return np.array(planes)
