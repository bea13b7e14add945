"""Adhering contacts along a path: when they form and snap off, and their forces in between."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from cnnsim.support import Flags, Floats
from tactile.core.loads import COLUMNS, PLACE, SHEAR, F
from tactile.elastic.adhesion import AdhesionLaw
from tactile.elastic.medium import Medium
from tactile.simulator.contacts.loads import Disc, Loads
from tactile.simulator.contacts.mounting import Rig, sum_of
from tactile.simulator.contacts.shapes import RoundShape
from tactile.simulator.contacts.shapes.flat_punch import FlatPunch

REACH = 1.5
"""Largest force of a table over the largest dry force of the path."""


def attached(path: Floats, snap: float, times: Floats) -> Flags:
    """Return whether a contact holds at the times [s]: it forms at a push of 0 and snaps off below ``snap``.

    Arguments: ``path`` (n, 2) rows (t, push), straight in between; before the first and after the last nothing holds.
    """
    events, state = [(float(path[0, 0]), bool(path[0, 1] >= 0))], bool(path[0, 1] >= 0)
    for (t0, p0), (t1, p1) in zip(path[:-1].tolist(), path[1:].tolist(), strict=True):
        level = snap if state else 0.0
        if p0 != p1 and (p1 < level if state else p1 >= level):
            state = not state
            events.append((t0 + (level - p0) / (p1 - p0) * (t1 - t0), state))
    at = np.searchsorted(np.array([t for t, _ in events]), times, side="right") - 1
    held = np.array([state for _, state in events])[np.maximum(at, 0)] & (at >= 0)
    last = path[-1, 0] if len(path) > 1 else np.inf
    return np.asarray(held & (times <= last))


def adhesion_table(
    body: RoundShape, medium: Medium, work: float, path: Floats, by_depth: bool, reach: float = REACH
) -> AdhesionLaw:
    """Return the law of an adhering body for a path of pushes, up to ``reach`` times the largest dry force."""
    most = max(float(path[:, 1].max()), 0.0)
    dry = float(body.force_at(np.array([most]), medium)[0]) if by_depth else most
    dry = max(dry, work * body.radius)  # about the pull-off force, where nothing else presses
    return body.adhesion(medium, work, reach * dry, by_depth)


def moved(rows: Floats, pull: Floats, table_to: Callable[[float], AdhesionLaw], rig: Rig) -> Floats:
    """Displace and raise contacts by the rig along their adhesion's law, in place; return their pulls [N].

    Contacts without force stay so. One that is raised beyond its snap-off is kept there.

    Arguments: ``rows`` (frames, 5 or more); ``table_to``: the law up to a multiple of the dry force.
    """
    law, reach = table_to(REACH), REACH
    rows[:], rises = rig.displaced(rows)
    pressed = rows[:, F].copy()
    touching, pressing = pressed != 0, pressed > 0
    deep = np.interp(pressed, law.pressed, law.indentation) + sum_of(rises)
    while deep.max(initial=0, where=touching) > law.indentation[-1]:
        reach *= 2
        law = table_to(reach)
    force, after = law.at(deep, True)
    pull = np.where(touching, force - after, pull)
    rows[:, F] = np.where(touching, after, pressed)
    rows[:, SHEAR] *= np.where(pressing, rows[:, F] / np.where(pressing, pressed, 1), 1)[:, None]
    return pull


def with_pull(loads: Loads, rows: Floats, force: Floats, body: RoundShape, medium: Medium) -> Loads:
    """Return a dry contact's loads with the surfaces' pull, which is spread as under a flat punch.

    Arguments: ``rows`` (frames, 5 or more) with the dry force; ``force`` (frames,) [N], the sum of both.
    """
    pull = np.zeros((len(rows), 1, COLUMNS))
    pull[..., PLACE], pull[:, 0, F] = rows[:, None, PLACE], force - rows[:, F]
    profile, unit = FlatPunch(body.radius).profile(medium)
    disc = Disc(pull, loads.discs[0].radii[:, :1], profile, unit, loads.discs[0].owner[:1])
    totals = loads.totals.copy()
    totals[:, 0, F] = force
    return replace(loads, totals=totals, discs=(*loads.discs, disc))
