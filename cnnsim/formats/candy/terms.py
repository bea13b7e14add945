"""From the blocks of a ``.tem`` file to templates: matrices become A and B, all other blocks become terms.

CANDY's differences are centre minus neighbour (``x-u`` is x_ij - u_kl); ours are neighbour minus centre. So functions
are mirrored, and if a function multiplies the difference (``x-x#x-x``), the weights change sign as well.
"""

from collections.abc import Iterator
from dataclasses import replace
from typing import cast

import numpy as np
from numpy.typing import ArrayLike

from cnnsim.formats.candy.content import Block, Call, Layer, Section
from cnnsim.network import AnyTemplate, Argument, LayeredTemplate, Quantity, Table, Template, Term
from cnnsim.network.table import from_pairs
from cnnsim.support import Floats, InputError, naming

_READS = {"feedback": "y", "control": "u"}


def section_template(section: Section, name: str) -> AnyTemplate:
    """Return the template of a section, one of layers if it has several.

    Raises:
        InputError: blocks whose meaning is not known, or numbers that make no template.
    """
    layers = sorted(section.layers, key=lambda layer: layer.number)
    if len(layers) == 1:
        return layer_template(layers[0], name)
    return LayeredTemplate([layer_template(layer, f"{name}, layer {layer.number}") for layer in layers], None, name)


def layer_template(layer: Layer, name: str) -> Template:
    """Return the template of one layer; its coupling to other layers are terms with ``layer`` set."""
    _refuse_doubles(layer)
    matrices = {
        kind: [_linear_part(block) for block in layer.blocks if _plain(block, layer) == kind] for kind in _READS
    }
    a, b = (_sum(matrices[kind]) for kind in ("feedback", "control"))
    terms = [term for block in layer.blocks for term in _terms(block, layer)]
    return Template(a, b, layer.current or 0.0, name, terms)


def _plain(block: Block, layer: Layer) -> str:
    """Return "feedback" or "control" for a block whose numbers belong to A or B, else ""."""
    own = block.source in (None, layer.number)
    kind = block.operation.removeprefix("nonlin_")
    return kind if own and kind in _READS else ""


def _linear_part(block: Block) -> Floats:
    return np.array([[0.0 if isinstance(entry, Call) else entry for entry in row] for row in block.rows])


def _sum(matrices: list[Floats]) -> Floats:
    """Return the sum of a linear and a non-linear block's numbers, which may differ in size."""
    side = max((matrix.shape[0] for matrix in matrices), default=1)
    total = np.zeros((side, side))
    for matrix in matrices:
        total += np.pad(matrix, (side - matrix.shape[0]) // 2)
    return total


def _terms(block: Block, layer: Layer) -> Iterator[Term]:
    """Yield the terms of a block: one for its numbers, unless they belong to A or B, and one for each function."""
    numbers = _linear_part(block)
    reads = _READS.get(block.operation.split("_")[-1], "")
    source = None if block.source in (None, layer.number) else (block.source or 1) - 1
    if block.operation == "nonlin_d" and numbers.any():
        raise InputError("NONLIN_D has a number other than 0, whose meaning is unknown; functions or 0 wanted")
    if numbers.any() and not _plain(block, layer):
        yield Term(numbers, f"{reads}_kl", delay=block.delay or 0.0, layer=source)
    for call in dict.fromkeys(entry for row in block.rows for entry in row if isinstance(entry, Call)):
        weights = np.array([[float(entry == call) for entry in row] for row in block.rows])
        argument = {"-": f"{reads}-{reads}", "0": reads, "": block.argument}[call.of]
        yield replace(from_candy(weights, _table(layer, call.letter), argument, block.factor), layer=source)


def from_candy(weights: ArrayLike, table: Table, argument: str, times: str = "") -> Term:
    """Return a CANDY interaction whose argument is ``x-u`` (centre minus neighbour), times perhaps another such one.

    ``a-`` in NONLIN_CONTROL is ``u-u``, in NONLIN_FEEDBACK ``y-y``; ``a0`` is the neighbour's value, ``u`` or ``y``.

    Raises:
        InputError: an argument of another form.
    """
    of, sign = _from_centre_minus_neighbour(argument)
    factor, turn = _from_centre_minus_neighbour(times) if times else (None, 1)
    matrix = np.asarray(weights, dtype=np.float64) * turn
    return Term(matrix, of, table.mirrored() if sign < 0 else table, factor)


def _from_centre_minus_neighbour(text: str) -> tuple[Argument, int]:
    """Return the argument and -1 if it is the negative of what was asked for, else +1."""
    centre, minus, neighbour = text.replace(" ", "").partition("-")
    letters = {"x", "y", "u"}
    if minus and {centre, neighbour} <= letters:
        return Argument(cast(Quantity, neighbour), cast(Quantity, centre)), -1
    if not minus and centre in letters:
        return Argument(cast(Quantity, centre)), 1
    raise InputError(f"CANDY argument {text!r}; x, y, u or centre minus neighbour such as x-u wanted")


def _table(layer: Layer, letter: str) -> Table:
    function = layer.function(letter)
    with naming(f"function {letter!r} of line {function.line}"):
        return from_pairs(int(function.linear), function.points)


def _refuse_doubles(layer: Layer) -> None:
    kinds = [(block.operation, block.source, block.delay) for block in layer.blocks]
    if double := next((kind for kind in kinds if kinds.count(kind) > 1), None):
        source = "" if double[1] is None else f" FROM {double[1]}"
        raise InputError(
            f"{double[0].upper()}{source} twice in layer {layer.number}: replaced or added is not known; delete one of "
            "them, or write their sum"
        )
