"""Simulated grasps with onsets in closed form: a sphere that slips from its rim inwards, on a force array."""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Literal

import numpy as np

from cnnsim.support import Floats
from tactile.core.frame import NORMAL, Frame, TaxelArray
from tactile.core.source import FrameStream, Provenance

NOISE = (1.1e-3, 1.1e-3, 3.6e-3)
"""[N] White noise of shear and normal, as measured on an idle PapillArray."""
NOISY = 0.05
"""[N] Noise of its worst pillar, in all components of one taxel."""
FINE = 32
"""Number of lines across a taxel for the integration of the pressure, because the rim bears little."""
SLIDE = 0.3
"""[s] Sliding time before the release."""

Drive = Literal["force", "way", "held"]


@dataclass(frozen=True)
class Grasp:
    """One simulated grasp: pressed, held, pulled until it slides (or not quite), released.

    ``rate`` [Hz]; ``radius`` a [m] of the contact at ``force`` P [N] and its ``middle`` (x, y) [m]; ``friction`` mu;
    ``along`` [rad] direction of the pull; ``drive``: the tangential force grows linearly ("force"), the object moves
    at constant speed ("way"), or it is pulled to ``most`` of mu P and held there ("held"). ``times`` [s]: first touch,
    fully pressed, start of the pull, gross slip (or end of the pull), opening, last touch, end. ``noisy`` (row, col).
    """

    seed: int
    array: TaxelArray
    rate: float
    force: float
    radius: float
    middle: tuple[float, float]
    friction: float
    along: float
    drive: Drive
    most: float
    speed: float
    times: tuple[float, ...]
    noisy: tuple[int, int]

    @property
    def truth(self) -> dict[str, float]:
        """Onsets [s] by kind of event; gross slip where Q = mu P."""
        touch, _, pull, slip, _, gone, _ = self.times
        known = {"contact": touch, "tangential_load": pull, "release": gone}
        return known | ({} if self.drive == "held" else {"slip": slip})

    def pull(self, t: Floats) -> Floats:
        """Return Q / (mu P) at times [s].

        Under a motion d at constant speed the contact carries Q = mu P (1 - (1 - d / d_slip)^(3/2)) (Mindlin 1949).
        """
        _, _, start, slip, *_ = self.times
        part = np.clip((t - start) / (slip - start), 0, 1)
        share: Floats = 1 - (1 - part) ** 1.5 if self.drive == "way" else part * self.most
        return share

    def forces(self) -> tuple[Floats, Floats]:
        """Return the times (n,) [s] and noiseless readings (n, rows, cols, 3) [N].

        q = mu p(r; a) - mu (c / a) p(r; c): the contact sticks in the circle c = a (1 - Q / mu P)^(1/3) (Cattaneo 1938,
        Mindlin 1949), so taxel i reads mu P h_i(a) - (mu P - Q) h_i(c), where h_i is its part of a Hertz pressure of
        that radius.
        """
        touch, pressed, _, slip, opening, gone, end = self.times
        t = np.arange(round(end * self.rate)) / self.rate
        normal = self.force * np.interp(t, [touch, pressed, opening, gone], [0, 1, 1, 0])
        share = self.pull(t)
        # a sliding contact slides on while the grip opens; a sticking one keeps its shear over pressing
        way = np.array([np.cos(self.along), np.sin(self.along)])
        gone_on = np.clip(t - slip, 0, opening - slip) * (0.0 if self.drive == "held" else self.speed)
        values = np.zeros((len(t), *self.array.shape, 3))
        for n in np.flatnonzero(normal > 0):
            size = self.radius * (normal[n] / self.force) ** (1 / 3)
            at = self.middle + way * gone_on[n]
            whole, most = self._parts(at, size), self.friction * normal[n]
            stuck = self._parts(at, size * max(1 - share[n], 0.0) ** (1 / 3)) if share[n] > 0 else whole
            values[n, ..., NORMAL] = normal[n] * whole
            values[n, ..., :NORMAL] = (most * whole - most * (1 - share[n]) * stuck)[..., None] * way
        return t, values

    def _parts(self, middle: Floats, radius: float) -> Floats:
        """Return the part (rows, cols) of a Hertz pressure of this radius [m] on every taxel."""
        if radius < self.array.pitch / FINE:  # a point
            return self._point(middle)
        rows, cols = self.array.shape
        x, y = _cuts(self.array, 0, 1) - middle[0], _cuts(self.array, 1, FINE) - middle[1]
        y = (y[1:] + y[:-1]) / 2
        half = np.sqrt(np.maximum(radius**2 - y**2, 0))[:, None]  # of the chord of the contact at this y
        at = np.clip(x, -half, half)
        # the pressure sqrt(half^2 - x^2) integrated from the middle of the chord
        area = at * np.sqrt(half**2 - at**2) + half**2 * np.arcsin(at / np.maximum(half, 1e-12 * radius))
        cells = np.diff(area).reshape(rows, FINE, cols).sum(axis=1) * self.array.pitch / (2 * FINE)
        parts: Floats = cells / (2 / 3 * np.pi * radius**3)
        return parts

    def _point(self, middle: Floats) -> Floats:
        away = np.abs(self.array.positions() - middle).max(axis=-1)
        here = (away == away.min()) & (away <= self.array.pitch / 2)
        return here / max(here.sum(), 1)

    def source(self) -> FrameStream:
        """Return the grasp as a source of noisy frames, a pure function of the seed."""
        t, values = self.forces()
        rng = np.random.default_rng((self.seed, 1))
        noise = np.broadcast_to(NOISE, (*self.array.shape, 3)).copy()
        noise[self.noisy] = NOISY
        values = values + rng.standard_normal(values.shape) * noise
        every = np.ones(self.array.shape, bool)
        frames = [Frame(0, time, n, one, every) for n, (time, one) in enumerate(zip(t.tolist(), values, strict=True))]
        return FrameStream(f"grasp {self.seed}", (self.array,), None, len(frames), frames, Provenance(untared=True))


def _cuts(array: TaxelArray, axis: int, each: int) -> Floats:
    """Return the edges [m] of the taxels along an axis, or of parts of each."""
    count = (array.cols, array.rows)[axis] * each
    return array.origin[axis] + (np.arange(count + 1) - count / 2) * array.pitch / each


def grasp(seed: int) -> Grasp:
    """Return the grasp of a seed: sizes, forces, friction and speeds typical of hands and grippers."""
    rng = np.random.default_rng(seed)
    size, pitch = int(rng.choice([3, 4, 6, 8])), float(rng.uniform(2e-3, 4e-3))
    array = TaxelArray("pad", size, size, pitch, 0.0, quantity="force")
    drive: Drive = ("force", "way", "held")[int(rng.integers(3))]
    lasts = rng.uniform((0.6, 0.05, 0.6, 0.15, 0.0, 0.05), (1.2, 0.4, 1.2, 1.0, 0.0, 0.15))
    lasts[4] = SLIDE
    ends = np.cumsum(lasts)
    return Grasp(
        seed,
        array,
        float(rng.choice([200.0, 500.0, 1000.0])),
        float(np.exp(rng.uniform(np.log(1.0), np.log(12.0)))),
        float(rng.uniform(1.0, 0.48 * size)) * pitch,
        (float(rng.uniform(-0.5, 0.5)) * pitch, float(rng.uniform(-0.5, 0.5)) * pitch),
        float(rng.uniform(0.3, 1.0)),
        float(rng.uniform(-np.pi, np.pi)),
        drive,
        float(rng.uniform(0.4, 0.75)) if drive == "held" else 1.0,
        float(rng.choice([0.0, 5e-3])),
        (*(float(end) for end in ends), float(ends[-1] + 0.4)),
        (int(rng.integers(size)), int(rng.integers(size))),
    )


def grasps(count: int, first: int = 0) -> Iterator[Grasp]:
    """Return a number of grasps with consecutive seeds."""
    return (grasp(seed) for seed in range(first, first + count))
