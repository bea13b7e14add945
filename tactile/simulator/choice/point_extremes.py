"""The ideal field of a scene of point loads, with its extremes: computed in one call, for choices are short."""

from itertools import accumulate

import numpy as np

from cnnsim.support import Floats, Integers
from cnnsim.support.compiled_loops import kept_njit
from tactile.core.loads import COLUMNS, F, Q
from tactile.elastic.halfspace import point_scale
from tactile.elastic.sums.direct import SERIAL_BELOW
from tactile.elastic.sums.direct_numba import MANY, few_loads
from tactile.simulator.choice.scan import scan
from tactile.simulator.contacts.loads import Loads
from tactile.simulator.contacts.moving_load import MovingLoad, follow_path
from tactile.simulator.field import Field
from tactile.simulator.slopes import Slopes, add_near


def points_alone(field: Field) -> bool:
    """Whether all that presses are a few point loads, summed on this processor and by one thread."""
    count, taxels = len(field.contacts), field.taxels.places.size // 2
    return (
        field.bumps is None
        and 0 < count < MANY
        and len(field.times) * taxels * count < SERIAL_BELOW
        and all(type(one) is MovingLoad for one in field.contacts)
    )


def point_extremes(field: Field, peaks: Floats, where: Integers, ends: Floats) -> Slopes:
    """Compute a whole field of points and its loads; return its slopes, and put the readings' extremes in place."""
    contacts: tuple[MovingLoad, ...] = field.contacts  # type: ignore[assignment]  # told by `points_alone`
    paths, places, depth = [one.path for one in contacts], field.taxels.places, field.taxels.depth
    starts = np.array([0, *accumulate(map(len, paths))])
    together = np.ascontiguousarray(paths[0]) if len(paths) == 1 else np.concatenate(paths)
    scale, trace = point_scale(depth, field.medium)
    sums = np.zeros(4)
    rows, values, hardest, largest = _point_extremes(
        together, starts, field.times, places.reshape(-1, 2), depth, trace, scale, peaks, where, ends, sums
    )
    loads = Loads(rows, rows, np.arange(len(paths)))
    field.__dict__.update(loads=loads, values=values.reshape(-1, *places.shape[:-1], 3))
    return Slopes(field.array, field.medium, sums, hardest, largest, True)


@kept_njit(error_model="numpy")
def _point_extremes(paths, starts, times, at, depth, trace, scale, peaks, where, ends, sums):  # type: ignore[no-untyped-def]  # numba types it at the call
    """Loads (frames, n, 5) along paths that follow each other, their readings, the hardest push, the largest reading.

    The readings' extremes, and the slopes' sums, are put in place.
    """
    frames, count = times.size, starts.size - 1
    rows, values = np.empty((frames, count, COLUMNS)), np.empty((frames, at.shape[0], 3))
    gone, near, hardest = np.empty(frames, np.bool_), np.zeros((frames, 4)), 0.0
    for m in range(count):
        follow_path(paths[starts[m] : starts[m + 1]], times, rows[:, m], gone)
        for n in range(frames):
            if gone[n]:
                rows[n, m, Q:] = 0
            hardest = max(hardest, rows[n, m, F])
    x, y = at[:, 0].copy(), at[:, 1].copy()
    few_loads(x, y, rows, values, 0, frames, 1 / depth, trace, scale)
    flat = values.reshape(frames, peaks.size)
    scan(flat, 0, flat[0], peaks, where, ends)
    add_near(rows, np.zeros((1, 0)), at, depth, near)
    for n in range(frames):
        for k in range(4):
            sums[k] = max(sums[k], near[n, k])
    for k in range(4):
        sums[k] *= scale * depth**2
    return rows, values, hardest, peaks.max()
