"""Margin of a template: how far its worst decision is from a tie, and the error of its entries that this allows."""

from dataclasses import dataclass

import numpy as np

from cnnsim.library.entry import LibraryEntry
from cnnsim.network import Template
from cnnsim.support import Floats
from cnnsim.theory.neighbourhood import DIGITS, pairs_of, too_many, weighted_sums


@dataclass(frozen=True)
class Margin:
    """The margin of the worst decision. ``value`` is None if no margin applies; ``why`` gives the reason.

    ``tolerated`` is the relative error epsilon of A, B and z, each entry free on its own, below which every cell still
    takes the right colour: exact for templates without neighbours (``exact``), at least that for others.
    """

    value: float | None
    tolerated: float | None
    exact: bool
    why: str


def margin_of(entry: LibraryEntry) -> Margin:
    """Return the margin of a library template over all black-and-white neighbourhoods, seen on a grid or not.

    Without neighbours in A: min |s + (a - 1) x(0)|, less 1 - a where a < 1 and the output has to saturate; s = B*u + z,
    and x(0) counts where it decides (a > 1). Coupled: min |(a - 1) y_c + sum A y + sum B u + z| over all combinations
    of nonzero taps, including impossible ones. Zarandy, "The art of CNN template design", Int. J. Circuit
    Theory Appl. 27 (1999) 5; Haenggi and Moschytz, IEEE Trans. CAS-I 46 (1999) 304.
    """
    template = entry.network
    if not isinstance(template, Template):
        return _none("it has several layers")
    if not template.linear:
        return _none("it has non-linear, delayed or space-variant terms")
    if entry.cell.model == "discrete-time" or entry.cell.characteristic is not None:
        return _none("its cells are not those of Chua and Yang")
    if "gray" in entry.tags and entry.margin is None:
        if template.self_feedback > 1:
            return _none("it works on grey values: how near a cell is to its decision is for the picture to say")
        return _none("it works on grey values: its output follows the picture continuously, and decides nothing")
    if template.uncoupled and works_on_grey(entry):
        return _none("it works on grey values: black-and-white neighbourhoods are not what it sees")
    if not template.uncoupled and template.self_feedback <= 1:
        return _none("a <= 1 among coupled cells: the outputs need not be black and white")
    return _uncoupled(entry) if template.uncoupled else _coupled(entry)


def works_on_grey(entry: LibraryEntry) -> bool:
    """Return whether a template is for grey pictures: by its tag, or by its worked pictures.

    An output that is compared within a tolerance is grey as well.
    """

    def grey(plane: Floats | None) -> bool:
        return plane is not None and not bool(np.isin(plane, (-1.0, 1.0)).all())

    examples = entry.examples
    return "gray" in entry.tags or any(e.tolerance is not None or grey(e.input) or grey(e.state) for e in examples)


def tolerated_error(m: Floats, x0: Floats | None, a: float, size: float) -> Floats:
    """Return the relative error of a, B and z up to which cells without neighbours keep their colour.

    With errors of at most epsilon the drive towards the right colour is at worst m - epsilon * size, and the feedback
    lies between a (1 - epsilon) and a (1 + epsilon); beyond 1 it adds (a - 1) x(0) d. The root of this piecewise linear
    function, which falls with epsilon, is epsilon.

    Arguments: ``m`` (n,) the drive s times the right colour d; ``x0`` (n,) the initial state times d, or None if it may
    be anything in [-1, 1]; ``size`` |z| + sum |B u|.
    """
    pull = -np.ones_like(m) if x0 is None else x0
    alone = np.divide(m, size, out=np.full_like(m, np.inf), where=np.full(m.shape, size > 0))
    if a <= 0:
        return np.maximum(alone, 0.0)
    weight = np.abs(pull)
    harmed = (m - weight * (a - 1)) / np.maximum(size + weight * a, 1e-300)
    harmed = np.where(alone <= max(1 / a - 1, 0.0), alone, harmed)
    helped = (m + weight * (a - 1)) / np.maximum(size + weight * a, 1e-300)
    helped = np.where(helped <= 1 - 1 / a, helped, np.maximum(alone, max(1 - 1 / a, 0.0)))
    error: Floats = np.where(pull < 0, harmed, np.where(pull > 0, helped, alone))
    return np.maximum(error, 0.0)


def _uncoupled(entry: LibraryEntry) -> Margin:
    template, a = entry.template, entry.template.self_feedback
    assert not isinstance(entry.initial_state, tuple)  # only networks of layers have one for each
    found = pairs_of(entry.input, entry.initial_state)
    if isinstance(found, str):
        return _none(found)
    centre = sum(tap.weight for tap in template.control_taps if tap.k == tap.l == 0)
    others = [tap.weight for tap in template.control_taps if (tap.k, tap.l) != (0, 0)]
    us = sorted({u for _, u in found})
    sums = weighted_sums([[(weight * u,) for u in us] for weight in others])
    if sums is None:
        return _none(too_many(len(others)))
    arbitrary = entry.initial_state == "any"
    smallest, tolerated = np.inf, np.inf
    for x0, u in found:
        s = sums[:, 0] + centre * u + template.z
        q = np.round(s + (0.0 if arbitrary else max(a - 1, 0.0) * x0), DIGITS)
        size = abs(template.z) + abs(u) * (abs(centre) + float(np.abs(others).sum()))
        colour = np.sign(q)
        smallest = min(smallest, float(np.abs(q).min()))
        error = tolerated_error(s * colour, None if arbitrary else x0 * colour, a, size)
        tolerated = min(tolerated, float(np.where(colour == 0, 0.0, error).min()))
    why = "exact, over all black-and-white neighbourhoods"
    return Margin(max(smallest - max(1 - a, 0.0), 0.0), tolerated, True, why)


def _coupled(entry: LibraryEntry) -> Margin:
    template = entry.template
    rest = [tap.weight for tap in template.feedback_taps if (tap.k, tap.l) != (0, 0)]
    weights = [template.self_feedback - 1, *rest, *(tap.weight for tap in template.control_taps)]
    sums = weighted_sums([[(weight,), (-weight,)] for weight in weights])
    if sums is None:
        return _none(too_many(len(weights)))
    value = float(np.abs(np.round(sums + template.z, DIGITS)).min())
    size = abs(template.z) + float(np.abs(template.A).sum() + np.abs(template.B).sum())
    why = "the smallest drive over all combinations of its taps, including impossible ones"
    return Margin(value, value / size, False, why)


def _none(why: str) -> Margin:
    return Margin(None, None, False, f"a margin does not apply: {why}")
