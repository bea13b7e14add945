"""What contacts put on one finger: loads at points, over circles, and twists, frame by frame. They add."""

from collections.abc import Iterable
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from cnnsim.support.types import Floats
from tactile.elastic.profiles import Profile

Index = NDArray[np.int64]


@dataclass(frozen=True)
class Disc:
    """Loads over circles: ``loads`` (frames, k, 5), ``radii`` and ``lam`` (frames, k); ``owner`` (k,) contacts."""

    loads: Floats
    radii: Floats
    lam: Floats
    profile: Profile
    owner: Index


@dataclass(frozen=True)
class Twist:
    """Twisted circles: ``twists`` (frames, k, 3) rows (x, y, M) [m, m, N m], ``radii`` (frames, k) [m]."""

    twists: Floats
    radii: Floats
    owner: Index


@dataclass(frozen=True)
class Pressed:
    """All that presses on one finger over some frames.

    ``totals`` (frames, contacts, 5): one row (x, y, Q, R, F) a contact, its resultant; ``loads`` (frames, n, 5):
    what acts at points, with the contact it belongs to in ``owner`` (n,); ``discs``, ``twists``: what is spread.
    """

    totals: Floats
    loads: Floats
    owner: Index
    discs: tuple[Disc, ...] = ()
    twists: tuple[Twist, ...] = ()

    def moved(self, shift: Floats, factor: Floats) -> "Pressed":
        """Contacts displaced by ``shift`` (frames, contacts, 2) [m], forces times ``factor`` (frames, contacts)."""

        def rows(of: Floats, owner: Index) -> Floats:
            return np.concatenate([of[..., :2] + shift[:, owner], of[..., 2:] * factor[:, owner, None]], axis=-1)

        every = np.arange(self.totals.shape[1])
        return Pressed(
            rows(self.totals, every),
            rows(self.loads, self.owner),
            self.owner,
            tuple(replace(disc, loads=rows(disc.loads, disc.owner)) for disc in self.discs),
            tuple(replace(twist, twists=rows(twist.twists, twist.owner)) for twist in self.twists),
        )


def point_loads(rows: Floats) -> Pressed:
    """One contact that acts at a point: ``rows`` (frames, 5)."""
    return Pressed(rows[:, None], rows[:, None], np.zeros(1, np.int64))


def together(parts: Iterable[Pressed], frames: int) -> Pressed:
    """Several contacts on one finger."""
    totals, loads, owner, discs, twists = [np.empty((frames, 0, 5))], [np.empty((frames, 0, 5))], [], [], []
    count = 0
    for part in parts:
        totals.append(part.totals)
        loads.append(part.loads)
        owner.append(part.owner + count)
        discs += [replace(disc, owner=disc.owner + count) for disc in part.discs]
        twists += [replace(twist, owner=twist.owner + count) for twist in part.twists]
        count += part.totals.shape[1]
    return Pressed(
        np.concatenate(totals, axis=1),
        np.concatenate(loads, axis=1),
        np.concatenate([np.empty(0, np.int64), *owner]),
        tuple(discs),
        tuple(twists),
    )
