"""Reads the network of a template file from its tables: A, B, z, terms, layers, and pictures in several planes.

A file has ``A``, ``B``, ``z`` and perhaps ``[[term]]`` tables, or ``[[layer]]`` tables that have them::

    [[term]]
    weights = [[...]]             # like A; the neighbour at offset (k, l)
    of      = "u_kl - u_ij"       # what the table is applied to: neighbour kl minus centre ij, or "y_kl"
    table   = { linear = [[-2, 2], [0, 0], [2, 2]] }        # or { step = { at = [0.2], values = [-1, 1] } }
    times   = "x_kl - x_ij"       # D type: a factor
    delay   = 10                  # time constants
    layer   = 0                   # whose neighbour, counted from 0; the own one if left out

Pictures of several planes (layers, or frames that follow one another) are lists of pictures.
"""

from dataclasses import fields
from typing import Any

import numpy as np

from cnnsim.network import AnyTemplate, LayeredTemplate, Template, Term
from cnnsim.network.table import parse_table
from cnnsim.support import Floats, InputError, naming
from cnnsim.support.errors import shown
from cnnsim.support.pictures.picture import parse_ascii
from cnnsim.support.toml_file import check_keys, line_of, located, take_tables

TEMPLATE_KEYS = ("A", "B", "z", "term", "layer")
_LAYER_KEYS = ("A", "B", "z", "term", "time_constant")
_TERM_KEYS = tuple(part.name for part in fields(Term))


def read_template(data: dict[str, Any], name: str) -> AnyTemplate:
    """Return the template of a file, of whatever kind.

    Raises:
        InputError: what is wrong, with the number of the layer or term.
    """
    if "layer" not in data:
        return _single_layer(data, name)
    extra = {"A", "B", "z", "term"} & data.keys()
    if extra:
        where = line_of(data, min(extra, key=list(data).index))
        raise InputError(
            f"layers and {', '.join(sorted(extra))}: with layers, each has its own A, B, z and terms{where}"
        )
    layers = []
    for number, table in enumerate(take_tables(data, "layer", "template")):
        check_keys(table, _LAYER_KEYS, f"layer {number}")
        with located(table), naming(f"layer {number}"):
            layers.append(_single_layer(table, f"{name}, layer {number}"))
    return LayeredTemplate(layers, [table.get("time_constant", 1.0) for table in data["layer"]], name)


def _single_layer(data: dict[str, Any], name: str) -> Template:
    check_keys(data, data, required=("A", "z"))
    terms = []
    for number, table in enumerate(take_tables(data, "term", "template")):
        check_keys(table, _TERM_KEYS, f"term {number}")
        with located(table), naming(f"term {number}"):
            values = table if "table" not in table else table | {"table": parse_table(table["table"])}
            terms.append(Term(**{"weights": None, **values}))
    for key in ("A", "B", "z"):
        with located(data, key):  # a template of this alone, so that what is wrong has its own line
            Template(**{"A": 0.0, key: data.get(key, 0.0)}, name=name)
    return Template(data["A"], data.get("B", 0.0), data["z"], name, terms)


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
