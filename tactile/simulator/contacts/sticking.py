"""Contacts that stick: when one is made and when it snaps off along a path, and what it carries in between."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from cnnsim.support import Flags, Floats
from tactile.core.loads import COLUMNS, PLACE, SHEAR, F
from tactile.elastic.adhesion import Adhesion, adhesion, flat_adhesion
from tactile.elastic.medium import Medium
from tactile.simulator.contacts.indenter import Indenter
from tactile.simulator.contacts.loads import Disc, Loads
from tactile.simulator.contacts.rig import Rig, sum_of

REACH = 1.5
"""Times the largest dry force that a law reaches."""


def attached(path: Floats, snap: float, times: Floats) -> Flags:
    """Whether a contact holds at the times [s]: made where its push is 0 or more, lost where it falls below ``snap``.

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


def table(
    indenter: Indenter, medium: Medium, work: float, path: Floats, by_depth: bool, reach: float = REACH
) -> Adhesion:
    """How an indenter sticks along a path of pushes, up to ``reach`` times the largest dry force."""
    most = float(path[:, 1].max())
    dry = indenter.force_at(np.array([max(most, 0.0)]), medium)[0] if by_depth else max(most, 0.0)
    dry = max(float(dry), work * indenter.radius)  # of the size of the pull where nothing else presses
    punch = replace(indenter, shape="flat_punch")
    if indenter.shape == "flat_punch":
        return flat_adhesion(indenter.radius, punch, medium, work, reach * dry)
    return adhesion(indenter, punch, medium, work, reach * dry, by_depth)


def moved(rows: Floats, pull: Floats, reaching: Callable[[float], Adhesion], rig: Rig) -> Floats:
    """Displace and raise contacts as the rig has them, along the law by which they stick; return their pulls [N].

    What does not touch stays so. A contact raised beyond the point where it snaps off is kept there: the rig has it
    back before long.

    Arguments: ``rows`` (frames, 5 or more), written to; ``reaching``: the law up to so many times the dry force.
    """
    law, reach = reaching(REACH), REACH
    rows[:], rises = rig.displaced(rows)
    pressed = rows[:, F].copy()
    touching, pressing = pressed != 0, pressed > 0
    deep = np.interp(pressed, law.pressed, law.indentation) + sum_of(rises)
    while deep.max(initial=0, where=touching) > law.indentation[-1]:
        reach *= 2
        law = reaching(reach)
    force, after = law.at(deep, True)
    pull = np.where(touching, force - after, pull)
    rows[:, F] = np.where(touching, after, pressed)
    rows[:, SHEAR] *= np.where(pressing, rows[:, F] / np.where(pressing, pressed, 1), 1)[:, None]
    return pull


def with_pull(loads: Loads, rows: Floats, force: Floats, indenter: Indenter, medium: Medium) -> Loads:
    """A dry contact's loads under what it is pressed with, and the pull of the surfaces beside it.

    Arguments: ``rows`` (frames, 5 or more) with the force pressed; ``force`` (frames,) [N] what is left of it.
    """
    punch = replace(indenter, shape="flat_punch")
    pull = np.zeros((len(rows), 1, COLUMNS))
    pull[..., PLACE], pull[:, 0, F] = rows[:, None, PLACE], force - rows[:, F]
    profile, unit = punch.profile(medium)
    disc = Disc(pull, loads.discs[0].radii[:, :1], profile, unit, loads.discs[0].owner[:1])
    totals = loads.totals.copy()
    totals[:, 0, F] = force
    return replace(loads, totals=totals, discs=(*loads.discs, disc))
