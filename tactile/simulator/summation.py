"""Strain or stress at taxels under all loads of a finger: direct sums, Fourier transforms, or a table of circles.

The rule: points on a half-space are summed directly; large maps on the taxels' own grid by transforms. Points on a
layer, circles and twists are read from a table as fine as the accuracy. Circles that are wider than ``WIDEST`` depths,
and all of them where the accuracy is finer than ``TABLES``, are integrated one by one; the table then gives only the
layer's share.
"""

import numpy as np

from cnnsim.support import Flags, Floats, InputError
from tactile.core.loads import PLACE
from tactile.elastic.medium import Medium
from tactile.elastic.sums.direct import FINEST, direct_sum
from tactile.simulator.contacts.loads import Disc, Loads

ACCURACY = 1e-4
"""Default error of a field, as a share of its peak."""
TABLES = 1e-5
"""Finest accuracy at which the half-space is read from tables: finer ones take longer to make than most scenes."""
WIDEST = 6.0
"""Largest radius in depths of circles whose half-space field is read from a table."""
FEWEST = 576
"""Fewest points that are summed by transforms."""
AT_ONCE = 1 << 22
"""Loads times frames that are held at once."""


def field_at(positions: Floats, depth: float, loads: Loads, medium: Medium, accuracy: float = ACCURACY) -> Floats:
    """Return the readings (frames, ..., 3) of taxels at ``positions`` (..., 2) [m] under all loads.

    Arguments: ``depth`` of the taxels [m]; ``accuracy``: the error, as a share of the field's peak, 0 for the direct
    sum alone on a half-space and for ``FINEST`` on a layer.

    Raises:
        InputError: taxels below the cover.
    """
    if depth > medium.thickness:
        raise InputError(
            f"taxels {depth * 1e3:g} mm deep in a cover of {medium.thickness * 1e3:g} mm, a thickness of at least the "
            "depth wanted"
        )
    values = _sum_points(positions, depth, loads.points, medium, accuracy)
    for pattern in loads.patterns:
        count = max(1, AT_ONCE // max(1, pattern.count(accuracy)))
        for start in range(0, len(values), count):
            part = slice(start, start + count)
            values[part] += _sum_points(positions, depth, pattern.of_frames(part).points(accuracy), medium, accuracy)
    at = positions.reshape(-1, 2)
    flat = values.reshape(len(values), len(at), 3)
    for disc in (*loads.discs, *loads.twists):
        _add_disc(flat, at, depth, disc, medium, accuracy)
    return values


def _sum_points(positions: Floats, depth: float, points: Floats, medium: Medium, accuracy: float) -> Floats:
    from tactile.elastic.sums.spectral import grid_sum  # imports SciPy's transforms

    values = grid_sum(positions, depth, points, medium) if points.shape[1] >= FEWEST else None
    return direct_sum(positions, depth, points, medium, max(accuracy, FINEST)) if values is None else values


def _add_disc(values: Floats, at: Floats, depth: float, disc: Disc, medium: Medium, accuracy: float) -> None:
    """Add the readings of taxels ``at`` (taxels, 2) under circles to ``values`` (frames, taxels, 3)."""
    from tactile.elastic.disc_loops import add_discs  # compiled
    from tactile.elastic.disc_table import disc_table, table_size

    pressing = (disc.loads[..., PLACE.stop :] != 0).any(axis=-1)
    tabled = (disc.radii <= WIDEST * depth) & (accuracy >= TABLES)
    if (pressing & ~tabled).any():
        _add_integrated(values, at, depth, disc, pressing & ~tabled, medium)
    size = table_size(disc.radii, depth, disc.profile, disc.unit)
    kinds = [(True, pressing & tabled)]
    if np.isfinite(medium.thickness):
        kinds.append((False, pressing & ~tabled))
    for half_space, these in kinds:
        for top in np.unique(size[these]).tolist():
            here = these & (size == top)
            table = disc_table(depth, top, disc.profile, disc.unit, medium, max(accuracy, FINEST), half_space)
            kept = here.any(axis=0)  # most circles are of one size in all frames
            rows = np.where(here[:, kept, None], disc.loads[:, kept], 0)
            add_discs(values, at, depth, rows, np.where(here, disc.radii, 0)[:, kept], table, medium)


def _add_integrated(values: Floats, at: Floats, depth: float, disc: Disc, these: Flags, medium: Medium) -> None:
    """Add the half-space's readings under ``these`` (frames, n) circles by quadrature."""
    from tactile.elastic.discs import disc_load

    kept = these.any(axis=0)
    rows = np.where(these[..., None], disc.loads, 0)[:, None, kept]
    radii = np.where(these, disc.radii, 0)[:, None, kept]
    values += disc_load(at, depth, rows, radii, disc.profile, medium, radii / disc.unit)
