"""Groups of numbers for the loops over terms: channels, tables of terms, layers, stages, planes, what lies around."""

from typing import Any, NamedTuple

from cnnsim.support import Array

# Python hands the groups over as bare tuples: see `cnnsim.backends.cpu.prepared`.


class ChannelColumns(NamedTuple):
    """One entry a channel: which plane of the ``inputs`` it is of (NOTHING: it follows the state), its layer, how many
    steps ago, and whether it is the output of a state.
    """

    plane: Array
    layer: Array
    ago: Array
    output: Array


class TermArrays(NamedTuple):
    """Terms and what they are of: ``channels`` are `ChannelColumns` as records, ``terms`` and ``taps`` the records of a
    `TermTable`, ``weights`` (its planes) and ``numbers`` its own.
    """

    channels: Array
    terms: Array
    taps: Array
    weights: Array
    numbers: Array


class StageTable(NamedTuple):
    """A scheme: the rows of a as a square, then b; how many steps ``ahead`` each stage looks; whether a stage asks for
    a rate that is not of the stage before.
    """

    numbers: Array
    ahead: Array
    keeps: bool


class Layers(NamedTuple):
    """How layers step: their ``gains``; ``limited``: states stay within +-1."""

    gains: Array
    limited: bool


class TermPlanes(NamedTuple):
    """What a task reads and writes, (n, layers, rows, cols): ``start``, the state of step 0 and before it; ``states``
    of later steps k in turn, at k modulo their number; ``inputs`` that channels are of; ``w``; and the words of the
    mask (n * layers, rows, words), without words none.
    """

    start: Array
    states: Array
    inputs: Array
    w: Array
    mask: Array


class Surround(NamedTuple):
    """What lies around the grid, ``r`` cells deep: a `BoundaryCode`, and what fixed virtual cells hold as u, and y."""

    r: int
    code: int
    of_input: Any
    of_state: Any
