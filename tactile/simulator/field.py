"""The strain or stress field at the taxels of one finger over some frames, before any electronics."""

from collections.abc import Iterable
from dataclasses import dataclass, field, replace
from functools import cached_property, partial
from typing import TYPE_CHECKING, Protocol

import numpy as np

from cnnsim.support import Flags, Floats, InputError
from tactile.core.frame import TaxelArray
from tactile.core.loads import COLUMNS, PLACE
from tactile.elastic.medium import Medium
from tactile.elastic.profiles import HERTZ
from tactile.simulator.contacts.loads import Disc, Loads, together
from tactile.simulator.contacts.rig import STILL, Rig
from tactile.simulator.summation import DIRECT, Summation, moving, sum_loads
from tactile.simulator.taxels import FINEST, Taxels

if TYPE_CHECKING:
    from tactile.elastic.sums.device_sum import DeviceSum
    from tactile.simulator.bump_cover import Bumps

ACCURACY = 1e-4
"""How far a field may be off, of its peak, unless a scene says."""
TABLES = 1e-6
"""To finer accuracies circles are integrated one by one: their tables would take longer than most scenes."""
WIDEST, WIDEST_FINE, WIDEST_ALONE = 6.0, 2.1, 12.0
"""Radius in depths up to which tables are made of circles on the half-space, that for accuracies finer than `FINE`,
where those of wider ones would take as long as ten thousand circles that are integrated one by one, and that of circles
which need a table of one radius only. Wider ones are felt by harmonics."""
FINE = 1e-5
PAIRS = 60
"""What a layer adds under circles wider than `WIDEST` is integrated one by one where tables would take longer: for
accuracies finer than `FINE`, minutes; else where loads times taxels are fewer than so many squared radii in depths."""


class Contact(Protocol):
    """Anything that presses on a finger. Contacts add."""

    @property
    def finger(self) -> int: ...  # noqa: D102 - the finger's number
    def loads(self, times: Floats, depth: float, medium: Medium, rig: Rig = ...) -> Loads: ...  # noqa: D102 - what it puts on the finger at the times


@dataclass(frozen=True)
class Field:
    """What the taxels feel, as what it comes from: it is computed when it is asked for, with all effects at once.

    ``contacts`` on this finger; ``times`` (n,) [s]; ``first``: number of the first frame; ``rig``: how contacts are
    held; ``taxels``: where they lie; ``method`` of summation; ``accuracy`` of the peak; ``bumps``: the cover has them;
    ``device``: where sums over loads are done, None for the CPU; ``trial``: too few frames for a table to pay.
    """

    array: TaxelArray
    medium: Medium
    times: Floats
    first: int
    contacts: tuple[Contact, ...]
    taxels: Taxels
    rig: Rig = STILL
    method: Summation = DIRECT
    accuracy: float = ACCURACY
    bumps: "Bumps | None" = field(default=None, compare=False)
    device: "DeviceSum | None" = field(default=None, compare=False)
    trial: bool = False

    @property
    def at_points(self) -> bool:
        """Whether every contact is one point load, whatever the cover: a force, with no law of its own."""
        return self.rig.tip == 0 and self.loads.points.shape[1] == len(self.contacts)

    @cached_property
    def loads(self) -> Loads:
        """What presses at the times."""
        parts = (contact.loads(self.times, self.taxels.depth, self.medium, self.rig) for contact in self.contacts)
        return together(parts, len(self.times))

    @cached_property
    def values(self) -> Floats:
        """(n, rows, cols, 3) in the medium's reading."""
        if self.bumps is not None:
            return self.bumps.readings(self.array, self.medium, self.loads)
        method = DIRECT if self.method.name != "direct" and moving(self.loads.points) else self.method
        return self.taxels.feel(
            lambda at, depth, medium: field_at(
                at, depth, self.loads, medium, method, self.accuracy, self.device, self.trial
            ),
            self.medium,
            self.accuracy,
            at_once=method.name != "fft",
        )

    def again(self, accuracy: float, first: int, times: Floats) -> "Field":
        """The same at some of its times, from frame ``first`` on, with what was computed; values may be written into.

        ``accuracy``: of what effects make of it, for which nothing is computed yet.
        """
        made = replace(self, accuracy=accuracy, first=first, times=times)
        part = slice(first, first + len(times))
        loads = self.loads if len(times) == len(self.times) else self.loads.of_frames(part)
        made.__dict__.update(loads=loads, values=self.values[part].copy())
        return made


def field_at(
    positions: Floats,
    depth: float,
    loads: Loads,
    medium: Medium,
    method: Summation | None = None,
    accuracy: float = ACCURACY,
    device: "DeviceSum | None" = None,
    trial: bool = False,
) -> Floats:
    """What taxels at ``positions`` (..., 2) feel of all loads: (frames, ..., 3).

    Points are summed by the method; in a layer where it is direct, and circles, twists and patterns, from tables as
    fine as the accuracy asks for, or one by one below `TABLES`; in a ``trial`` on the half-space circles by a rough
    quadrature, since a table for a few frames does not pay. What is not there is not imported.

    Raises:
        InputError: taxels below the cover.
    """
    if depth > medium.thickness:
        raise InputError(
            f"taxels {depth * 1e3:g} mm deep in a cover of {medium.thickness * 1e3:g} mm, a thickness of at least the "
            "depth wanted"
        )
    layered = np.isfinite(medium.thickness)
    directly = method is None or method.name == "direct"
    by_table = layered and directly and accuracy >= TABLES
    if by_table:
        values = np.zeros((len(loads.points), *positions.shape[:-1], 3))
    else:
        if device is not None and directly:
            values = np.zeros((len(loads.points), *positions.shape[:-1], 3))
            device.add_points(values.reshape(len(values), -1, 3), positions.reshape(-1, 2), depth, loads.points, medium)
        else:
            values = sum_loads(method, positions, depth, loads.points, medium)
        if layered and directly and loads.points.shape[1]:
            from tactile.elastic.sums.layer_sum import add_layer_term  # only where called for

            at = positions.reshape(-1, 2)
            add_layer_term(values.reshape(len(values), len(at), 3), at, depth, loads.points, medium)
    at = positions.reshape(-1, 2)
    flat = values.reshape(len(values), len(at), 3), at
    for pressed in loads.patterns:
        from tactile.simulator.contacts.load_pattern import add_cells, add_tabled  # only where called for

        if accuracy >= TABLES and pressed.pattern.fits(depth, medium, accuracy):
            feel = partial(add_tabled, positions=at, depth=depth, medium=medium, accuracy=accuracy)
        else:
            feel = partial(add_cells, summed=partial(_points, at, depth, medium, device))
        pressed.add(flat[0], feel, (at.tobytes(), depth, medium, accuracy))
    spread = [*loads.discs]
    spread += [
        Disc(_as_sixth(twist.twists), twist.radii, twist.profile, twist.unit, twist.owner) for twist in loads.twists
    ]
    if by_table and loads.points.shape[1]:
        spread.append(Disc(loads.points, np.zeros(loads.points.shape[:2]), HERTZ, np.inf, loads.owner))
    if spread:
        _add_spread(*flat, depth, spread, medium, accuracy, device, trial)
    return values


def _as_sixth(twists: Floats) -> Floats:
    rows = np.zeros((*twists.shape[:2], COLUMNS + 1))
    rows[..., [0, 1, COLUMNS]] = twists
    return rows


def _points(at: Floats, depth: float, medium: Medium, device: "DeviceSum | None", points: Floats) -> Floats:
    """What taxels feel of point loads (frames, n, 5), load by load."""
    if device is None:
        values = sum_loads(DIRECT, at, depth, points, medium)
    else:
        values = np.zeros((len(points), len(at), 3))
        device.add_points(values, at, depth, points, medium)
    if np.isfinite(medium.thickness):
        from tactile.elastic.sums.layer_sum import add_layer_term  # only where called for

        add_layer_term(values, at, depth, points, medium)
    return values


def _add_spread(
    values: Floats, at: Floats, depth: float, spread: Iterable[Disc], medium: Medium, accuracy: float,
    device: "DeviceSum | None", trial: bool,
) -> None:  # fmt: skip
    layered = bool(np.isfinite(medium.thickness))
    if trial and not layered:
        for disc in spread:
            _add_exact(values, at, depth, disc, disc.loads, medium, rough=True)
        return
    if device is None:
        from tactile.elastic.disc_loops import add_discs  # only where called for
    else:
        add_discs = device.add_discs
    from tactile.elastic.disc_table import disc_table, table_size  # the same

    for disc in spread:
        rows, radii, profile, unit, lone = disc.loads, disc.radii, disc.profile, disc.unit, disc.flat
        pressing = (rows[..., PLACE.stop :] != 0).any(axis=-1)
        widest = (WIDEST_ALONE if lone else WIDEST_FINE if accuracy < FINE else WIDEST) * depth
        alone = pressing & ((radii > widest) | (accuracy < TABLES))
        if alone.any():
            wide = _add_wide(values, at, depth, disc, alone, medium, accuracy) if accuracy >= TABLES else ~alone
            if not wide.all():
                _add_exact(values, at, depth, disc, np.where((alone & ~wide)[..., None], rows, 0), medium)
        added = alone & (radii > WIDEST * depth) & (layered and not (lone and accuracy >= FINE))
        if accuracy >= FINE:
            added &= np.count_nonzero(added) * len(at) < PAIRS * (radii / depth) ** 2
        if added.any():
            from tactile.elastic.layer_discs import add_layer  # only where called for

            add_layer(values, at, depth, np.where(added[..., None], rows, 0), radii, profile, unit, medium)
        size = table_size(radii, depth, profile, unit, lone)
        for whole, these in ((True, pressing & ~alone), (False, alone & ~added & layered)):
            for top in np.unique(size[these]).tolist():
                here = these & (size == top)
                table = disc_table(depth, top, profile, unit, medium, max(accuracy, FINEST), whole, lone)
                kept = here.any(axis=0)  # most are of one size from the first frame to the last
                part = np.where(here[:, kept, None], rows[:, kept], 0)
                add_discs(values, at, depth, part, np.where(here, radii, 0)[:, kept], table, medium)


def _add_wide(
    values: Floats, at: Floats, depth: float, disc: Disc, these: Flags, medium: Medium, accuracy: float
) -> Flags:
    """The half-space's share of these of its loads by harmonics; return where that was, or where there is nothing."""
    from tactile.elastic.wide_discs import add_wide, harmonics  # only where called for

    radii = np.where(these, disc.radii, 0)
    found, enough = harmonics(disc.profile, (radii / disc.unit)[these], radii[these] / depth, accuracy)
    done = ~these
    done[these] = enough
    coefficients = np.zeros((*these.shape, found.shape[1]))
    coefficients[these] = found
    add_wide(values, at, depth, disc.loads, np.where(done, radii, 0), coefficients, medium)
    return done


def _add_exact(
    values: Floats, at: Floats, depth: float, disc: Disc, rows: Floats, medium: Medium, rough: bool = False
) -> None:
    """The half-space's share of these of its loads by quadrature."""
    from tactile.elastic.discs import disc_load, twist_load  # only where called for

    radii = disc.radii[:, None]
    if rows.shape[-1] == COLUMNS:
        values += disc_load(at, depth, rows[:, None], radii, disc.profile, medium, radii / disc.unit, rough)
    else:
        twists = rows[:, None][..., [0, 1, COLUMNS]]
        values += twist_load(at, depth, twists, radii, medium, disc.profile, radii / disc.unit)
