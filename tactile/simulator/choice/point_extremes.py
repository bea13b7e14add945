"""The ideal field of a short scene of point loads, with its extremes: computed in one call, for choices are short."""

import numpy as np

from cnnsim.support import Floats, Integers
from cnnsim.support.compiling.kept_loops import kept_njit
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
        and field.device is None
        and field.method.name == "direct"
        and 0 < count < MANY
        and len(field.times) * taxels * count < SERIAL_BELOW
        and all(type(one) is MovingLoad for one in field.contacts)
    )


def point_extremes(field: Field, peaks: Floats, where: Integers, ends: Floats) -> Slopes:
    """Compute a whole field of points and its loads; return its slopes, and put the readings' extremes in place."""
    contacts: tuple[MovingLoad, ...] = field.contacts  # type: ignore[assignment]  # told by `points_alone`
    paths = [np.ascontiguousarray(one.path) for one in contacts]
    count, frames, places, depth = len(paths), len(field.times), field.taxels.places, field.taxels.depth
    at = places.reshape(-1, 2)
    rows, values = np.empty((frames, count, COLUMNS)), np.empty((frames, len(at), 3))
    gone, sums = np.empty(frames, np.bool_), np.zeros((frames, 4))
    for m, path in enumerate(paths):
        follow_path(path, field.times, rows[:, m], gone)
        if path[0, 0] > field.times[0] or path[-1, 0] < field.times[-1]:
            rows[gone, m, Q:] = 0
    scale, trace = point_scale(depth, field.medium)
    hardest = _point_extremes(rows, at, depth, trace, scale, values, peaks, where, ends, sums)
    owner = np.zeros(1, np.int64) if count == 1 else np.arange(count)
    loads = Loads(rows, rows, owner)
    field.__dict__.update(loads=loads, values=values.reshape(frames, *places.shape[:-1], 3))
    most = scale * depth**2 * sums.max(axis=0)
    return Slopes(field.array, field.medium, most, hardest, float(peaks.max()), True)


@kept_njit(error_model="numpy")
def _point_extremes(rows, at, depth, trace, scale, values, peaks, where, ends, sums):  # type: ignore[no-untyped-def]  # numba types it at the call
    """Readings, their extremes and the near sums of the loads (frames, n, 5); return the hardest normal force."""
    x, y = at[:, 0].copy(), at[:, 1].copy()
    few_loads(x, y, rows, values, 0, rows.shape[0], 1 / depth, trace, scale)
    flat = values.reshape(values.shape[0], peaks.size)
    scan(flat, 0, flat[0], peaks, where, ends)
    add_near(rows, np.zeros((1, 0)), at, depth, sums)
    hardest = 0.0
    for n in range(rows.shape[0]):
        for m in range(rows.shape[1]):
            hardest = max(hardest, rows[n, m, F])
    return hardest
