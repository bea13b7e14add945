"""Equation of a cellular neural network: templates, terms, tables, layers, cells and boundaries."""

from cnnsim.network.boundary import PERIODIC, ZERO_FLUX, Boundary, fixed, pad, parse_boundary
from cnnsim.network.cell import CellModel
from cnnsim.network.characteristic import CHUA_YANG, Cell, Characteristic
from cnnsim.network.frames import Frames
from cnnsim.network.layers import AnyTemplate, LayeredTemplate, layered
from cnnsim.network.sides import Sides
from cnnsim.network.table import Table
from cnnsim.network.template import Template
from cnnsim.network.term import Argument, Quantity, Term
from cnnsim.network.weights import Tap, reach

__all__ = [
    "CHUA_YANG",
    "PERIODIC",
    "ZERO_FLUX",
    "AnyTemplate",
    "Argument",
    "Boundary",
    "Cell",
    "CellModel",
    "Characteristic",
    "Frames",
    "LayeredTemplate",
    "Quantity",
    "Sides",
    "Table",
    "Tap",
    "Template",
    "Term",
    "fixed",
    "layered",
    "pad",
    "parse_boundary",
    "reach",
]
