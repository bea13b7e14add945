"""Fit of a learned detector: a sparse template on planes by a squared hinge, then its read-out by the wire."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import product

import numpy as np

from cnnsim.support import Array, Flags, Floats, InputError
from tactile.learning.collect import Example
from tactile.learning.front import KEPT, Front
from tactile.score.match import WINDOW, Tally

GUARD, NEAR = 0.03, 0.15
"""[s] Frames less than the first before an onset are not used; frames within the second of an onset are all used."""
EVERY, CELLS = 4, 12
"""Elsewhere one frame in this number is used; the mean number of taxels of a frame that are used."""
DECAY, SPARSITY, ROUNDS = 1e-5, 3e-4, (4, 2, 1)
"""Penalties on squares and moduli of the weights; each round keeps this multiple of the limit, the largest weights."""
SHIFTS, CONFIRMS, RELEASE = (0.0, -0.5, -0.25, 0.25, 0.5), (0.0, 0.01, 0.02, 0.04, 0.08), 0.25
"""Tried shifts of the drive, and times [s] for which the event must last; time off [s] after which it has ended."""
LEVELS = (8, 16, 32, 64, 1024)
"""Tried grids of the weights, the coarsest first: steps up to the largest weight."""


@dataclass(frozen=True, eq=False)
class Learned:
    """A template on planes of ``front``: ``weights`` (planes, 2) of the cell and of each neighbour, and ``z``.

    Touched taxels whose drive is above 0 are black. The event is on while any of them is (``most`` False), or more than
    half of them are. ``confirm`` and ``lag`` [s] as in `EventRule`.
    """

    front: Front
    weights: Floats
    z: float
    most: bool
    confirm: float
    lag: float

    def drive(self, example: Example, names: Sequence[str]) -> Floats:
        """Return the drive (n, rows, cols) of the planes of an example, which are ``names``, without z."""
        total = np.zeros(example.touch.shape)
        for name, (own, ring) in zip(self.front.names, self.weights, strict=True):
            values = example.planes[:, names.index(name)].astype(np.float32)
            total += own * values + (ring * around(values) if ring else 0)
        return total

    def tally(self, examples: Sequence[Example], drives: Sequence[Floats], window: float = WINDOW) -> Tally:
        """Return the agreement of the detector with examples, whose `drive` is known."""
        total = Tally()
        for one, drive in zip(examples, drives, strict=True):
            black, touched = ((drive > -self.z) & one.touch).sum(axis=(1, 2)), one.touch.sum(axis=(1, 2))
            on = 2 * black > touched if self.most else black > 0
            total.add([t - self.lag for t in begins(one.t, on, self.confirm)], one.known, window)
        return total


def around(values: Array) -> Array:
    """Return the sum of the eight neighbours of each cell (n, rows, cols), edges repeated."""
    rows, cols = values.shape[1:]
    wide = np.pad(values, ((0, 0), (1, 1), (1, 1)), mode="edge")
    return np.asarray(sum(wide[:, k : k + rows, l : l + cols] for k, l in np.ndindex(3, 3)) - values)


def begins(t: Floats, on: Flags, confirm: float) -> list[float]:
    """Return the onsets of events by the rules of `Tracker`."""
    turns = np.flatnonzero(np.diff(np.concatenate([[False], on, [False]]).astype(int)))
    found, until = list[float](), -np.inf
    for start, end in zip(turns[::2], turns[1::2], strict=True):
        goes_on = start > 0 and t[start - 1] - until < RELEASE
        if not goes_on and t[end - 1] - t[start] < confirm:
            continue
        found += [] if goes_on else [float(t[start])]
        until = t[min(end, len(t) - 1)]
    return found


def fit(examples: Sequence[Example], front: Front, limit: int, lasting: float, seed: int = 0) -> Learned:
    """Return the detector with at most ``limit`` weights that fits examples whose planes are those of ``front``.

    An event lasts at least ``lasting`` [s]. The rest of its contact is not used.

    Raises:
        InputError: no taxel is touched during any event.
    """
    x, y, share = _samples(examples, lasting, np.random.default_rng(seed))
    if not (y > 0).any():
        raise InputError(f"no taxel is touched within {lasting:g} s of any labelled event; labels of touches wanted")
    kept, solution = np.flatnonzero(_useful(x)), np.empty(0)
    for rounds in (*ROUNDS, 0):
        columns = np.append(kept, x.shape[1] - 1)
        solution = _solve(x[:, columns], y, share, SPARSITY if rounds else 0.0)
        if rounds:
            kept = np.sort(kept[np.argsort(-np.abs(solution[:-1]))[: rounds * limit]])
    weights = np.zeros(x.shape[1] - 1)
    weights[kept] = solution[:-1]
    both = weights.reshape(2, -1).T / (1, 8)
    used = np.flatnonzero(both.any(axis=1))
    names = front.names
    planes = tuple(names[n] for n in used if n < len(front.planes))
    marked = tuple(names[n].removesuffix(KEPT) for n in used if n >= len(front.planes))
    first = Learned(Front(planes, marked), both[used], float(solution[-1]), False, 0.0, 0.0)
    drives = [first.drive(one, names) for one in examples]
    trials = [
        replace(first, z=first.z + shift, most=most, confirm=confirm)
        for most, confirm, shift in product((True, False), CONFIRMS, SHIFTS)
    ]
    best = max((_timed(one, examples, drives) for one in trials), key=lambda one: _merit(one.tally(examples, drives)))
    good = _merit(best.tally(examples, drives))[0]
    for levels in LEVELS:
        coarse = _on_grid(best, levels)
        if _merit(coarse.tally(examples, [coarse.drive(one, names) for one in examples]))[0] >= good:
            break
    return coarse


def _samples(examples: Sequence[Example], lasting: float, rng: np.random.Generator) -> tuple[Floats, Floats, Floats]:
    """Return features (m, 2 planes + 1) of touched taxels, whether the event is on there (+-1), and their weights."""
    features, signs, shares = list[Array](), list[Array](), list[Array]()
    for one in examples:
        first = min(one.known, default=np.inf)
        event = np.zeros(len(one.t), bool)
        for t in one.known:
            event |= (one.t >= t) & (one.t < min(t + lasting, one.until))
        use = event | (one.t < first - GUARD)
        near = np.abs(one.t[:, None] - np.array(one.known or [-np.inf])).min(axis=1) < NEAR
        use &= near | (np.arange(len(one.t)) % EVERY == 0)
        frames = np.flatnonzero(use & one.touch.any(axis=(1, 2)))
        planes = one.planes[frames].astype(np.float32)
        ring = np.stack([around(planes[:, k]) for k in range(planes.shape[1])], axis=1)
        both = np.concatenate([planes, ring / 8], axis=1)
        chosen = one.touch[frames] & (rng.random(one.touch[frames].shape) < CELLS / one.touch[0].size)
        n, i, j = np.nonzero(chosen)
        features.append(both[n, :, i, j])
        signs.append(np.where(event[frames][n], 1.0, -1.0))
    for sign in signs:
        mine = np.ones(len(sign))
        for value in (-1, 1):
            mine[sign == value] = 1 / max((sign == value).sum(), 1)
        shares.append(mine)
    y, share = np.concatenate(signs), np.concatenate(shares)
    for value in (-1, 1):
        share[y == value] /= 2 * share[y == value].sum()
    x = np.concatenate(features)
    return np.concatenate([x, np.ones((len(x), 1), np.float32)], axis=1), y, share


def _useful(x: Array) -> Flags:
    """Return which features vary; of planes that are uniform the mean of the neighbours does not help."""
    own, ring = np.split(x[:, :-1], 2, axis=1)
    varies = np.ptp(own, axis=0) > 0
    return np.concatenate([varies, varies & (own != ring).any(axis=0)])


def _solve(x: Array, y: Floats, share: Floats, sparsity: float) -> Floats:
    """Return the weights that minimise the squared hinge; the last one, z, is free of penalties."""
    from scipy.optimize import minimize  # slow to import

    penal = np.append(np.ones(x.shape[1] - 1), 0.0)

    def objective(w: Floats) -> tuple[float, Floats]:
        lack = np.maximum(0, 1 - y * (x @ w.astype(np.float32)))
        rounded = np.sqrt(w**2 + 1e-6)
        value = share @ lack**2 + DECAY * (penal @ w**2) + sparsity * (penal @ rounded)
        slope = -2 * ((share * y * lack).astype(np.float32) @ x) + penal * (2 * DECAY * w + sparsity * w / rounded)
        return float(value), slope.astype(np.float64)

    found: Floats = minimize(objective, np.zeros(x.shape[1]), jac=True, method="L-BFGS-B", options={"maxiter": 80}).x
    return found


def _timed(one: Learned, examples: Sequence[Example], drives: Sequence[Floats]) -> Learned:
    """Return the detector with the lag that is the median error of its onsets."""
    errors = one.tally(examples, drives, 2 * WINDOW).errors
    return replace(one, lag=max(round(float(np.median(errors)), 3), 0.0) if errors else 0.0)


def _merit(found: Tally) -> tuple[float, float]:
    """Return the F1 score, and minus the mean modulus of the errors."""
    score = 2 * found.hit / max(2 * found.hit + found.false + found.missed, 1)
    return score, -float(np.mean(np.abs(found.errors))) if found.errors else -np.inf


def _on_grid(one: Learned, levels: int) -> Learned:
    """Return the detector with whole weights, the largest ``levels``; those of neighbours are whole eighths."""
    whole = one.weights * (1, 8)
    step = float(np.abs(whole).max(initial=1e-3)) / levels
    return replace(one, weights=np.rint(whole / step) / (1, 8), z=float(np.floor(one.z / step) + 0.5))
