"""Random trials of located loads: ``python -m tests.tactile.inverse.trials [--count N] [--kind KIND ...]``.

Kinds: sound loads; a channel of the strongest taxel that is dead (reads zero), silent (reads noise) or turned (opposite
sign), or all three stuck at other values; readings clipped at an unknown end; a second load of 0.05 to 0.1 of the
first, 2 to 3 depths away; a layer of 1 to 2 depths; a ball with a contact radius of up to a depth. Pads of 2 x 2 to
16 x 16 taxels, half a depth to two depths apart, or with ``--lines`` lines of 4 to 12; strain and stress; noise of 1e-6
to 3e-2 of the largest signal, known or not. Printed are, of the loads that are INSIDE: the part beyond 5 of their own
standard deviations, the parts of places within 1 and 2, and the median ratio of the error to the Cramer-Rao bound over
its value for a normal distribution. TaxelSignals are summed here, by eqs (1) and (10).
"""

import argparse
from dataclasses import dataclass

import numpy as np

from cnnsim.support import Floats
from tactile.core.frame import TaxelArray
from tactile.elastic.medium import Medium
from tactile.inverse.load import Load
from tactile.inverse.validity import Validity
from tests.kits.touch.pads import DEPTH, MODULUS, SCALE, as_row, found
from tests.oracles.elastic.layer import layer_load
from tests.oracles.elastic.localise import bound

SHAPES = ((2, 2), (2, 3), (3, 3), (4, 4), (5, 5), (8, 8), (16, 16))
LINES = ((1, 4), (1, 5), (1, 6), (1, 8), (8, 1), (1, 12), (6, 1))
PITCHES = (0.5, 1.0, 1.0, 1.5, 2.0)
KINDS = ("sound", "dead", "turned", "clipped", "second", "layer", "ball", "stuck", "silent")


@dataclass(frozen=True)
class Trial:
    """One trial: the true loads, the located one, and its errors."""

    kind: str
    shape: tuple[int, int]
    stress: bool
    pitch: float
    level: float
    known: bool
    loads: Floats
    load: Load
    more: float
    named: bool

    @property
    def inside(self) -> bool:
        """Whether the answer is INSIDE."""
        return self.load.validity is Validity.INSIDE

    @property
    def nearest(self) -> Load:
        """The located load nearest to the first one."""
        x, y = self.loads[0, :2]
        return min((self.load, *self.load.others), key=lambda one: float(np.hypot(one.x - x, one.y - y)))

    @property
    def off(self) -> Floats:
        """Errors (5,) of the nearest answer, 0 of a shear that a line does not measure."""
        near = np.array(as_row(self.nearest))
        x, y, q, r, f = self.loads[0]
        if self.shape[0] == 1:  # F of the equivalent load without the shear across the line
            near[3], f, r = 0.0, f - r * y / DEPTH, 0.0
        if self.shape[1] == 1:
            near[2], f, q = 0.0, f - q * x / DEPTH, 0.0
        return near - (x, y, q, r, f)

    @property
    def sigmas(self) -> Floats:
        """Errors (5,) of the nearest answer over its deviations."""
        return np.abs(self.off) / np.array(self.nearest.sigma)

    @property
    def beyond(self) -> bool:
        """Whether the answer is inside and lies beyond 5 of its deviations."""
        return self.inside and bool(self.sigmas.max() > 5)

    @property
    def over_bound(self) -> Floats:
        """Errors (2,) of the place over the Cramer-Rao bound of all signals."""
        noise = self.level * float(np.abs(self.forward(self.loads)).max())
        free = (0, 1, *((2,) if self.shape[0] == 1 else (3,) if self.shape[1] == 1 else (2, 3)), 4)
        return self.off[:2] / bound(self.forward, self.loads[0], noise, SCALE, free)[:2]

    def forward(self, loads: Floats) -> Floats:
        """Return the signals of loads on this pad."""
        at = TaxelArray("pad", *self.shape, self.pitch * DEPTH, DEPTH).positions()
        return point_signals(at, loads, self.stress)


def point_signals(at: Floats, loads: Floats, stress: bool) -> Floats:
    """Return the signals of taxels (rows, cols, 2) under loads (k, 5) on the half-space, by eq. (1) or (10)."""
    signals = np.zeros((*at.shape[:2], 3))
    for x, y, q, r, f in loads:
        dx, dy, z = at[..., 0] - x, at[..., 1] - y, DEPTH
        rho = dx * dx + dy * dy
        s = q * dx + r * dy + f * z
        if stress:
            size = -3 * z * s / (2 * np.pi * (rho + z * z) ** 2.5)
            signals += size[..., None] * np.stack([dx, dy, np.full_like(dx, z)], axis=-1)
        else:
            size = 3 * s / (4 * np.pi * MODULUS * (rho + z * z) ** 2.5)
            signals += size[..., None] * np.stack([-3 * dx * z, -3 * dy * z, rho - 2 * z * z], axis=-1)
    return signals


def ball(load: Floats, radius: float) -> Floats:
    """Return a load with Hertz's pressure over a disc, as 200 equal point loads on a sunflower."""
    share = (np.arange(200) + 0.5) / 200
    out = radius * np.sqrt(1 - (1 - share) ** (2 / 3))
    turn = np.arange(200) * np.pi * (3 - 5**0.5)
    parts = np.repeat(load[None], 200, axis=0)
    parts[:, 0] += out * np.cos(turn)
    parts[:, 1] += out * np.sin(turn)
    parts[:, 2:] /= 200
    return parts


def trial(kind: str, random: np.random.Generator, shapes: tuple[tuple[int, int], ...] = SHAPES) -> Trial:
    """Return a random trial of a kind."""
    shape = shapes[random.integers(len(shapes))]
    pitch, stress, known = float(random.choice(PITCHES)), bool(random.integers(2)), bool(random.integers(2))
    at = TaxelArray("pad", *shape, pitch * DEPTH, DEPTH).positions()
    half = np.array([shape[1], shape[0]]) * pitch * DEPTH / 2
    force, turn = random.uniform(0.1, 1), random.uniform(0, 2 * np.pi)
    shear = force * random.uniform(0, 0.6)
    loads = np.array([[*random.uniform(-1, 1, 2) * half, shear * np.cos(turn), shear * np.sin(turn), force]])
    more, level = 0.0, 10 ** random.uniform(-6, np.log10(3e-2))
    if kind in ("second", "layer"):
        known = True
    if kind == "second":
        level, more = 1e-5, random.uniform(0.05, 0.1)
        while True:
            far, way = random.uniform(2, 3) * DEPTH, random.uniform(0, 2 * np.pi)
            place = loads[0, :2] + far * np.array([np.cos(way), np.sin(way)])
            if (np.abs(place) <= half + 0.5 * DEPTH).all() or half.max() < 1.6 * DEPTH:
                break
            loads[0, :2] = random.uniform(-1, 1, 2) * half
        loads = np.concatenate([loads, [[*place, 0, 0, more * force]]])
    if kind == "layer":
        level, more = 10 ** random.uniform(-5, -2), random.uniform(1, 2)
        medium = Medium(MODULUS, quantity="stress" if stress else "strain")
        signals = layer_load(at, DEPTH, loads, more * DEPTH, medium)
    elif kind == "ball":
        more = random.uniform(0.2, 1)
        signals = point_signals(at, ball(loads[0], more * DEPTH), stress)
    else:
        signals = point_signals(at, loads, stress)
    peak, bad = float(np.abs(signals).max()), np.zeros(shape, bool)
    read = signals + random.normal(size=signals.shape) * level * peak
    if kind in ("dead", "turned", "stuck", "silent"):
        worst = np.unravel_index(np.abs(signals).max(axis=-1).argmax(), shape)
        channel = int(random.integers(3))
        if kind == "stuck":
            read[worst] = random.normal(size=3) * peak * random.choice([0.3, 1, 3])
        elif kind == "silent":
            read[worst][channel] -= signals[worst][channel]
        else:
            read[worst][channel] *= 0.0 if kind == "dead" else -1.0
        bad[worst] = True
    if kind == "clipped":
        end = random.uniform(0.5, 0.9) * peak
        bad[:] = (np.abs(read) > end).any(axis=-1)
        read = np.clip(read, -end, end)
    load = found(at, read, stress, level * peak if known else None)
    named_taxels = {*load.saturated} if kind == "clipped" else {*load.left_out, *load.saturated}
    named = bool(bad.any()) and set(map(tuple, np.argwhere(bad).tolist())) <= named_taxels
    return Trial(kind, shape, stress, pitch, level, known, loads, load, more, named)


def line(name: str, trials: list[Trial]) -> str:
    """Return the statistics of these trials."""
    kept = [one for one in trials if one.inside]
    if not kept:
        return f"{name:24} {len(trials):5}  none inside"
    own = np.array([one.sigmas[:2] for one in kept])
    ratio = ""
    if kept[0].kind == "sound":
        ratio = f" error/bound {np.median(np.abs([one.over_bound for one in kept])) / 0.6745:.3f}"
    return (
        f"{name:24} {len(trials):5} inside {len(kept) / len(trials):6.1%} beyond 5 sigma "
        f"{np.mean([one.beyond for one in kept]):5.1%} within 1 {np.mean(own < 1):.3f} within 2 {np.mean(own < 2):.3f}"
        f"{ratio} right number {np.mean([1 + len(one.load.others) == len(one.loads) for one in kept]):.0%} named "
        f"{np.mean([one.named for one in trials]):.0%}"
    )


def main() -> None:
    """Draw, locate, report."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--count", type=int, default=300)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--kind", nargs="*", default=KINDS)
    parser.add_argument("--lines", action="store_true", help="lines of taxels, not pads")
    given = parser.parse_args()
    for kind in given.kind:
        shapes, number = LINES if given.lines else SHAPES, KINDS.index(kind)
        trials = [trial(kind, np.random.default_rng((given.seed, number, n)), shapes) for n in range(given.count)]
        print(line(kind, trials))
        for known in (True, False):
            some = [one for one in trials if one.known is known]
            if some and len(some) < len(trials):
                print(line(f"    {'' if known else 'un'}known noise", some))


if __name__ == "__main__":
    main()
