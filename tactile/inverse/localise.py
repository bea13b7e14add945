"""Localisation of the loads of a frame: the place on which the taxels agree, then least squares to all signals.

Every taxel's inverse has up to two candidates, one for each sign of s = Q x + R y + F z, and under shear the sign may
differ from taxel to taxel. Only the true place is common to all of them.
"""

from dataclasses import replace

import numpy as np
from numpy.typing import ArrayLike

from cnnsim.operations.cellwise import Planes
from cnnsim.support import Flags, Floats, InputError
from tactile.core.frame import TaxelArray
from tactile.elastic.layer_field import layer_field
from tactile.inverse.leave_one_out import unstable
from tactile.inverse.limits import DOUBT, FEWEST, MISLED, POINT, UNSURE
from tactile.inverse.load import INF, NAN, Load
from tactile.inverse.model_selection import best_model
from tactile.inverse.multi_fit import close_pairs, large_pad, local_statistics
from tactile.inverse.single_fit import Candidate, Taxels
from tactile.inverse.validity import Validity
from tactile.inverse.weights import Weights, newtons, weigh

NO_LOAD = Load(validity=Validity.NO_LOAD)
Cells = tuple[tuple[int, int], ...]


class FrameFit:
    """Fit of one point load to a frame of a strain or stress array, in one compiled call.

    Called with readings and weights it returns what the inverse in every cell and `localise` would return, or None
    where models have to be compared. Arguments: ``modulus`` E [Pa] of an array that measures strain; ``floor``: largest
    signal that is no load.
    """

    def __init__(self, array: TaxelArray, modulus: float | None, floor: float) -> None:
        strain, depth = array.quantity == "strain", array.depth
        self._at = np.ascontiguousarray(array.positions().reshape(-1, 2), np.float64)
        layer = layer_field(array.thickness, depth, strain)
        self._units = newtons(array, modulus), depth, float(floor), strain, layer
        self._planes, self._cols = np.empty((0, 4, 0)), array.cols

    def __call__(self, values: Floats, weights: Weights) -> Load | None:
        """Return the load of the readings (rows, cols, 3) if one load explains them."""
        read = np.ascontiguousarray(values, np.float64)
        return _single(read, self._planes, self._at, weights, self._units, self._cols)


def _single(
    values: Floats, planes: Floats, at: Floats, weights: Weights, units: tuple[float, float, float, bool, Floats],
    cols: int,
) -> Load | None:  # fmt: skip
    from tactile.inverse.single_fit_numba import DOUBTFUL, FOUND, single_load  # numba is slow to import

    answer, noise = np.empty(19 + len(at)), weights.noise or 0.0
    said = single_load(values, planes, at, weights.scale, weights.trust, *units, noise, answer)
    if said != FOUND:
        return None if said == DOUBTFUL else NO_LOAD
    x, y, q, r, f, dx, dy, dq, dr, df, sx, sy, sq, sr, sf, misfit, taxels, inside, unread = answer[:19].tolist()
    validity, out = Validity.INSIDE if inside else Validity.OUTSIDE, _cells(answer[19 : 19 + int(unread)], cols)
    sigma, scatter = (dx, dy, dq, dr, df), (sx, sy, sq, sr, sf)
    return Load(x, y, q, r, f, sigma, misfit, int(taxels), validity, out, scatter=scatter)


def localise(
    positions: Floats, pressing: Planes, pulling: Planes | None, depth: float,
    noise: Weights | Floats | float | None = None,
    saturated: Flags | None = None, thickness: float | None = None,
) -> Load:  # fmt: skip
    """Find the point load, or the few, that cause the readings of an array.

    Start: the weighted mean of the candidates nearest to each other, one a taxel, where a candidate at
    t = rho^2 / z^2 weighs (signal / (1 + t))^2: the inverse variance of its place for equal noise in the signals.
    Then (x, y, Q, R, F) by least squares to the signals of all taxels. Where the residuals exceed the noise, models
    with a false or clipped reading, a false taxel, or several loads are compared. For three taxels without noise the
    components are those of eq. (14). On pads of more than 16 taxels a side up to 30 loads are fitted jointly.

    Arguments: ``positions`` (rows, cols, 2) of the taxels [m]; ``pressing``: the planes (dx, dy, force, validity)
    of ``invert_strain`` with pressing = 1, or of ``invert_stress``; ``pulling``: those with pressing = -1, None
    for stress; ``depth`` z [m]; ``noise``: standard deviation of the signals, one number or (rows, cols, 3), times
    4 pi E z^2 / 3 for strain and 2 pi z^2 / 3 for stress [N], or the weights that `weigh` makes of it; None: equal
    noise, estimated from the residuals; ``saturated`` (rows, cols): taxels with a reading at the end of the range,
    which are not used; ``thickness`` [m] of the cover, an elastic layer bonded to a rigid base; None if unknown: the
    half-space, whose misfit shows thin covers. Taxels that are not INSIDE or OUTSIDE are not used.

    Raises:
        InputError: planes or noise that do not have the array's shape, noise that is not positive, a cover
            thinner than the taxels lie deep.

    Source: Vasarhelyi, Fodor, Roska, eqs (1), (10), (12) to (14).
    """
    families, shape = [pressing] if pulling is None else [pressing, pulling], positions.shape[:2]
    planes = np.array(families, dtype=np.float64)
    if planes.shape[2:] != shape:
        raise InputError(f"planes of shape {planes.shape[2:]} for an array of {shape} taxels; equal shapes wanted")
    weights = noise if isinstance(noise, Weights) else weigh(noise, shape)
    at, strain = np.ascontiguousarray(positions, np.float64), pulling is not None
    planes = planes.reshape(len(families), 4, -1)
    railed: Flags = np.zeros(planes.shape[2], bool) if saturated is None else saturated.ravel()
    planes[:, 3, railed] = Validity.INVALID
    layer = layer_field(thickness, depth, strain)
    units = 0.0, depth, 0.0, strain, layer
    load = _single(np.empty((*shape, 0)), planes, at.reshape(-1, 2), weights, units, shape[1])
    if load is None:
        load = _compared(Taxels(at, planes, depth, strain, weights, layer))
    if not railed.any():
        return load
    ends = _cells(np.flatnonzero(railed), shape[1])
    left_out = tuple(taxel for taxel in load.left_out if taxel not in ends)
    return replace(load, left_out=left_out, saturated=tuple(sorted({*load.saturated, *ends})))


def _compared(taxels: Taxels) -> Load:
    """Return the load, or the loads, of the model that explains the signals of the taxels."""
    marked = bool((taxels.planes[:, 3] == Validity.INVALID).any())
    if not taxels.order.size:
        return Load(validity=Validity.INVALID if marked else Validity.NO_LOAD)
    single = taxels.single(taxels.order)
    found = large_pad(taxels, single)
    if found is not None:
        loads = _loads(taxels, found, local=True)
    else:
        found = best_model(taxels, single) if taxels.order.size >= FEWEST else single
        loads = _loads(taxels, found, local=False)
    first, clipped = loads[0], _cells(found.clipped, taxels.shape[1])
    unread = {taxel for load in loads for taxel in _unread(taxels, load)} if marked else set()
    left_out = tuple(sorted({*first.left_out, *unread}))
    return replace(first, left_out=left_out, saturated=clipped, others=tuple(loads[1:]))


def _loads(taxels: Taxels, found: Candidate, *, local: bool) -> list[Load]:
    """Return the loads of a model in metres and newtons; ``local``: each is judged by the taxels around it."""
    from tactile.inverse.fit_numba import student  # numba is slow to import

    fit, depth, top, cols = found.fit, taxels.depth, found.top, taxels.shape[1]
    gone = np.setdiff1d(taxels.order, found.order)
    out = _cells(np.union1d(gone, np.array(found.false, np.intp)), cols)
    tie, origin = fit.signals.tie.tolist(), taxels.at[found.order[0]] - fit.signals.seen[0] * depth
    units = np.array([depth, depth, top if tie[0] <= 0 else INF, top if tie[2] <= 0 else INF, top])
    many = len(fit.loads)
    variance, excess, misfits = np.full(many, fit.variance), np.full(many, fit.excess), np.full(many, fit.misfit)
    beyond = fit.unexplained
    if local:
        variance, excess, misfits = local_statistics(fit)
        beyond = excess[:, None] * fit.spread
    if fit.signals.noise is None:
        variance = variance * student(fit.free) ** 2
    doubt = found.ambiguous or unstable(fit, left_out=bool(out))
    limit = POINT if len(fit.loads) == 1 or local else DOUBT
    patch = close_pairs(fit.loads) & local
    with np.errstate(invalid="ignore"):
        wide = (variance + excess) * fit.spread[:, :2].max(axis=1) > UNSURE**2
        known, noise = np.isfinite(units), variance[:, None] * fit.spread
        scatters = np.where(known, np.sqrt(noise) * units, INF)
        sigmas = np.where(known, np.sqrt(noise + np.where(beyond > 0, beyond, 0.0)) * units, INF)
        values = np.where(known, fit.loads * units, NAN)
    loads = []
    for k, (x, y) in enumerate(fit.loads[:, :2]):
        near = float(((fit.signals.seen - (x, y)) ** 2).sum(axis=1).min())
        validity = Validity.INSIDE if near < 2 else Validity.OUTSIDE
        if misfits[k] > limit or patch[k] or (fit.foreign is not None and not local):
            validity = Validity.NOT_ONE
        elif doubt or wide[k] or sigmas[k, :2].max() > MISLED * depth:
            validity = Validity.AMBIGUOUS
        place_x, place_y = (origin + fit.loads[k, :2] * depth).tolist()
        q, r, f = values[k, 2:].tolist()
        sigma, scatter = tuple(sigmas[k].tolist()), tuple(scatters[k].tolist())
        misfit, count = float(misfits[k]), len(found.order)
        loads.append(Load(place_x, place_y, q, r, f, sigma, misfit, count, validity, out, scatter=scatter))
    return loads


def _unread(taxels: Taxels, load: Load) -> Cells:
    """Return the taxels under a load that have no answer."""
    from tactile.inverse.single_fit_numba import unread  # numba is slow to import

    cells = np.empty(len(taxels.at))
    count = unread(taxels.at, taxels.planes, load.x, load.y, taxels.depth, cells)
    return _cells(cells[:count], taxels.shape[1])


def _cells(numbers: ArrayLike, cols: int) -> Cells:
    """Return the rows and columns of taxels by their numbers, in order."""
    return tuple(divmod(int(k), cols) for k in sorted(np.asarray(numbers).tolist()))
