"""Perturbations of recordings: converter steps, tempo, rate, lost frames, noise, drift, frozen taxel, gain, axes."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from cnnsim.support import Flags, Floats, InputError
from tactile.core.frame import NORMAL, SHEAR_X, Frame
from tactile.core.source import FrameStream, Source, provenance
from tactile.thresholds.threshold import CONTACT

BLOCK, GAP, EVERY = 0.05, 0.15, 1.0
"""[s] Length of a block of equal stamps; length of a gap of frames, and the interval between two gaps."""
SPIKE, RARE = 5.0, 1e-3
"""[N] Height of a spike, and the part of the readings that have one."""
SWAY, SWAY_RATE = 0.05, 2.0
"""[N], [Hz] Shear along x that is added to every taxel."""


class Readings(NamedTuple):
    """Frames of one finger: ``t`` (n,) [s], ``values`` (n, rows, cols, 3) and ``valid`` (n, rows, cols)."""

    t: Floats
    values: Floats
    valid: Flags

    def at(self, index: Flags | Floats) -> "Readings":
        """Return the frames of an index."""
        return Readings(self.t[index], self.values[index], self.valid[index])


Change = Callable[[Readings, float, np.random.Generator], Readings]
"""Function of the frames of a finger, the unit of its readings per newton, and a generator of random numbers."""


@dataclass(frozen=True)
class Perturbation:
    """A change of recordings; ``tempo``: known times are divided by it."""

    group: str
    name: str
    change: Change
    tempo: float = 1.0


def steps(size: float) -> Change:
    """Round readings to a converter step [N]."""
    return lambda taken, unit, rng: taken._replace(values=np.round(taken.values / (size * unit)) * (size * unit))


def tempo(factor: float) -> Change:
    """Divide the stamps by a factor; the frame rate changes with it."""
    return lambda taken, unit, rng: taken._replace(t=taken.t / factor)


def rate(hertz: float) -> Change:
    """Return frames at a fixed rate: the latest frame, or at a higher rate the interpolated one."""

    def change(taken: Readings, unit: float, rng: np.random.Generator) -> Readings:
        t = np.arange(taken.t[0], taken.t[-1], 1 / hertz)
        last = np.searchsorted(taken.t, t, "right") - 1
        again = Readings(t, taken.values[last], taken.valid[last])
        if hertz * (taken.t[-1] - taken.t[0]) <= len(taken.t):
            return again
        after = np.minimum(last + 1, len(taken.t) - 1)
        span = taken.t[after] - taken.t[last]
        part = np.where(span > 0, (t - taken.t[last]) / np.where(span > 0, span, 1), 0)[:, None, None, None]
        return again._replace(values=again.values + part * (taken.values[after] - again.values))

    return change


def blocks(taken: Readings, unit: float, rng: np.random.Generator) -> Readings:
    """Give the frames of a block the stamp of its end, as a driver that passes them on together does."""
    return taken._replace(t=np.ceil(taken.t / BLOCK) * BLOCK)


def lost(taken: Readings, unit: float, rng: np.random.Generator) -> Readings:
    """Drop half of the frames at random."""
    return taken.at(rng.random(len(taken.t)) < 0.5)


def gaps(taken: Readings, unit: float, rng: np.random.Generator) -> Readings:
    """Drop all frames of a gap, once in a fixed interval."""
    return taken.at(np.mod(taken.t - taken.t[0], EVERY) < EVERY - GAP)


def spikes(taken: Readings, unit: float, rng: np.random.Generator) -> Readings:
    """Add spikes of either sign to single readings."""
    signs = rng.choice([-1.0, 1.0], taken.values.shape) * (rng.random(taken.values.shape) < RARE)
    return taken._replace(values=taken.values + SPIKE * unit * signs)


def sway(taken: Readings, unit: float, rng: np.random.Generator) -> Readings:
    """Add a sine to the shear along x of all taxels."""
    values = taken.values.copy()
    values[..., SHEAR_X] += (SWAY * unit * np.sin(2 * np.pi * SWAY_RATE * taken.t))[:, None, None]
    return taken._replace(values=values)


def noise(sigma: float) -> Change:
    """Add white noise [N]."""
    return lambda taken, unit, rng: taken._replace(
        values=taken.values + sigma * unit * rng.standard_normal(taken.values.shape)
    )


def drift(slope: float) -> Change:
    """Add a drift [N/s] to all components of all taxels."""
    return lambda taken, unit, rng: taken._replace(
        values=taken.values + slope * unit * (taken.t - taken.t[0])[:, None, None, None]
    )


def _most_pressed(taken: Readings) -> tuple[Floats, int, int]:
    """Return the load of all taxels (n, rows, cols), and the row and column of the most pressed one."""
    load = np.abs(taken.values[..., NORMAL] - taken.values[0, ..., NORMAL])
    row, col = np.unravel_index(int(np.nanargmax(np.nanmean(load, axis=0))), load.shape[1:])
    return load, int(row), int(col)


def frozen(taken: Readings, unit: float, rng: np.random.Generator) -> Readings:
    """Freeze the most pressed taxel in the middle of the frames in which its load is above half of its largest."""
    load, row, col = _most_pressed(taken)
    loaded = np.flatnonzero(load[:, row, col] > np.nanmax(load[:, row, col]) / 2)
    held = np.flatnonzero(load[:, row, col] > np.nanmedian(load[loaded[0] : loaded[-1] + 1, row, col]) / 2)
    start, values = int(held[len(held) // 2]), taken.values.copy()
    values[start:, row, col] = values[start, row, col]
    return taken._replace(values=values)


def dead(taken: Readings, unit: float, rng: np.random.Generator) -> Readings:
    """Hold the most pressed taxel at its first reading in all frames."""
    _, row, col = _most_pressed(taken)
    values = taken.values.copy()
    values[:, row, col] = values[0, row, col]
    return taken._replace(values=values)


def repeated(taken: Readings, unit: float, rng: np.random.Generator) -> Readings:
    """Repeat every fourth frame three times in place of its successors."""
    held = np.arange(len(taken.t)) // 4 * 4
    return Readings(taken.t, taken.values[held], taken.valid[held])


def gain(factor: float) -> Change:
    """Multiply all readings by a factor."""
    return lambda taken, unit, rng: taken._replace(values=factor * taken.values)


def rotation(degrees: float) -> Change:
    """Rotate the shear axes; the taxels stay in place."""
    sine, cosine = (round(float(of(np.radians(degrees))), 15) for of in (np.sin, np.cos))
    turn = np.array([[cosine, sine, 0.0], [-sine, cosine, 0.0], [0.0, 0.0, 1.0]])
    return lambda taken, unit, rng: taken._replace(values=taken.values @ turn)


def mirror(taken: Readings, unit: float, rng: np.random.Generator) -> Readings:
    """Mirror the grid left to right, with its shear."""
    return Readings(taken.t, taken.values[:, :, ::-1] * (-1.0, 1.0, 1.0), taken.valid[:, :, ::-1])


def unchanged(taken: Readings, unit: float, rng: np.random.Generator) -> Readings:
    """Return the readings as they are."""
    return taken


UNCHANGED = Perturbation("unchanged", "unchanged", unchanged)
ALL = (
    UNCHANGED,
    *(Perturbation("steps", f"steps {1e3 * size:g} mN", steps(size)) for size in (0.005, 0.01, 0.02, 0.05, 0.1)),
    *(Perturbation("tempo", f"tempo x {one:g}", tempo(one), one) for one in (1 / 16, 1 / 4, 1 / 2, 2.0, 4.0)),
    *(Perturbation("rate", f"rate {one:g} Hz", rate(one)) for one in (25.0, 50.0, 100.0, 250.0, 1000.0)),
    Perturbation("blocks", "stamps in blocks of 50 ms", blocks),
    Perturbation("lost", "half of the frames lost", lost),
    Perturbation("gaps", "gaps of 150 ms", gaps),
    Perturbation("spikes", "spikes of 5 N", spikes),
    Perturbation("sway", "sway of 50 mN at 2 Hz", sway),
    Perturbation("noise", "white noise of 10 mN", noise(0.01)),
    Perturbation("drift", "drift of 100 mN/s", drift(0.1)),
    Perturbation("frozen", "a taxel freezes", frozen),
    Perturbation("dead", "the most pressed taxel is dead", dead),
    Perturbation("repeated", "three of four rows repeated", repeated),
    *(Perturbation("gain", f"gain x {one:g}", gain(one)) for one in (0.01, 0.1, 10.0, 100.0)),
    *(Perturbation("rotation", f"axes rotated by {one:g} degrees", rotation(one)) for one in (45.0, 90.0)),
    Perturbation("mirror", "grid mirrored", mirror),
)
"""All perturbations, in the order of the table."""


def chosen_perturbations(names: str) -> list[Perturbation]:
    """Return the perturbations of the groups in a list with commas, "all" for all; the unchanged readings come first.

    Raises:
        InputError: an unknown group.
    """
    groups = list(dict.fromkeys(one.group for one in ALL))
    wanted = groups if names == "all" else [name.strip() for name in names.split(",")]
    unknown = [name for name in wanted if name not in groups]
    if unknown:
        raise InputError(f"perturbation {', '.join(unknown)}; all, or some of {', '.join(groups[1:])} wanted")
    return [one for one in ALL if one.group in (*wanted, "unchanged")]


def perturbed(source: Source, how: Perturbation, seed: int = 0) -> FrameStream:
    """Return a perturbed source, a pure function of the source and the seed."""
    fingers: list[list[Frame]] = [[] for _ in source.arrays]
    for frame in source:
        fingers[frame.finger].append(frame)
    found: list[Frame] = []
    for number, (array, frames) in enumerate(zip(source.arrays, fingers, strict=True)):
        if not frames:
            continue
        taken = Readings(
            np.array([one.t for one in frames]), np.array([one.values for one in frames]),
            np.array([one.valid for one in frames]),
        )  # fmt: skip
        unit = CONTACT[array.quantity].dead_band / CONTACT["force"].dead_band
        new = how.change(taken, unit, np.random.default_rng((seed, number)))
        found += [
            Frame(number, t, n, values, valid)
            for n, (t, values, valid) in enumerate(zip(new.t.tolist(), new.values, new.valid, strict=True))
        ]
    found.sort(key=lambda one: one.t)
    return FrameStream(source.title, source.arrays, source.modulus, len(found), found, provenance(source))
