"""Features of a window of a slide: the paper's two figures, or a full set of spectra, autocorrelation and coupling."""

from collections.abc import Iterable
from dataclasses import dataclass
from itertools import pairwise
from typing import Literal, get_args

import numpy as np

from cnnsim.support import Floats, InputError
from cnnsim.support.limits import WINDOW, check_most
from tactile.materials.slide import Slide
from tactile.materials.spectra import band_means, coupling, memory, spectrum

Kind = Literal["figures", "full"]
CHANNELS = ("shear_x", "shear_y", "normal", "friction")
PAIRS = ((0, 2), (1, 2), (0, 1))
"""Pairs of channels with coupling features: each shear with the normal, and both shears."""
BANDS, FINE = 16, 4
"""Number of bands of a spectrum, and of frequencies in each band."""
LAGS = np.array([1, 2, 3, 4, 6, 8, 12, 16, 24, 32])
"""Lags of the autocorrelation, in samples of the training slides."""
SHIFTS = np.array([-8, -4, -2, -1, 1, 2, 4, 8])
"""Lags of the coupling of two channels."""
FLOOR = 0.05
"""Pressing over the mean of the window, below which a sample has no friction value: the finger jumps."""
SHORTEST = 8
"""Least number of samples of a window for the full set."""


@dataclass(frozen=True)
class FeatureSet:
    """The features of a window of ``window`` samples.

    ``kind``: "figures" are friction coefficient and roughness, eqs (19), (20), as logarithms; "full" adds

        mean shear / mean normal, log mean normal, log (spread / mean normal) of each channel,
        log of the relative power in bands, from least squares at the sample times,
        autocorrelation, correlation of the shears with the normal at several lags,
        mean step, skewness and kurtosis of each channel,

    all but the means after subtraction of a parabola. ``frequencies`` [1/s], or [1/m] if the speed of the slides is
    known (``by_way``), and ``spacing`` [s] or [m] of the lags come from the training slides, so that spectra of other
    rates and, by way, other speeds are compared at the same frequencies. Without ``shear`` in the slides the full set
    has the features of the normal channel alone.

    Source: Vasarhelyi, Fodor, Roska, eqs (19), (20) for the two figures.
    """

    kind: Kind
    window: int
    frequencies: Floats
    spacing: float
    by_way: bool = False
    shear: bool = True

    @property
    def names(self) -> tuple[str, ...]:
        """A name for each feature."""
        names = ["friction", "roughness"]
        if self.kind == "figures":
            return tuple(names)
        unit = "1/m" if self.by_way else "Hz"
        edges = np.geomspace(self.frequencies[0], self.frequencies[-1], BANDS + 1)
        if not self.shear:
            bands = (f"normal {low:.3g} to {high:.3g} {unit}" for low, high in pairwise(edges))
            ends = ("step normal", "skewness normal", "kurtosis normal")
            return ("mean normal", "spread normal", *bands, *(f"normal after {lag}" for lag in LAGS), *ends)
        names += ["mean shear_x", "mean shear_y", "mean normal", *(f"spread {name}" for name in CHANNELS)]
        names += [f"{name} {low:.3g} to {high:.3g} {unit}" for name in CHANNELS for low, high in pairwise(edges)]
        pairs = [f"{CHANNELS[a]} with {CHANNELS[b]}" for a, b in PAIRS]
        for sign in ("in phase", "out of phase"):
            names += [f"{pair} {sign}, bands {k}" for pair in pairs for k in range(BANDS // 2)]
        names += [f"{name} after {lag}" for name in CHANNELS[:3] for lag in LAGS]
        names += [f"{pair} after {lag}" for pair in pairs for lag in SHIFTS]
        names += [f"{CHANNELS[a]} with {CHANNELS[b]}" for a in range(4) for b in range(a + 1, 4)]
        return tuple(names + [f"{what} {name}" for what in ("step", "skewness", "kurtosis") for name in CHANNELS])

    def __call__(self, t: Floats, force: Floats, speed: float | None = None) -> Floats:
        """Return the features of one window: ``t`` (n,) [s]; ``force`` (n, 3) as in `Slide`; ``speed`` [m/s].

        NaN where less than half of it is pressed, or nothing changes.
        """
        along = (t - t[0]) * (speed if self.by_way and speed is not None else 1.0)
        with np.errstate(all="ignore"):
            return self._features(along, force) if self.shear else self._of_normal(along, force[:, 2])

    def _features(self, at: Floats, force: Floats) -> Floats:
        level = force[:, 2].mean()
        firm = force[:, 2] > FLOOR * level
        if not (level > 0 and firm.mean() > 0.5):
            return np.full(len(self.names), np.nan)
        known = np.hypot(force[firm, 0], force[firm, 1]) / force[firm, 2]
        friction = known.mean()
        two = np.log([friction, 100 * known.std(ddof=1) / friction])
        if self.kind == "figures":
            return two
        mu = np.interp(at, at[firm], known)
        channels = np.column_stack([force, mu * level])
        parabola = np.vander(2 * at / at[-1] - 1, 3)
        rest = (channels - parabola @ np.linalg.lstsq(parabola, channels, rcond=None)[0]).T
        spread = rest.std(axis=1, keepdims=True)
        rest = rest / np.where(spread > 0, spread, np.nan)
        waves = spectrum(at, rest, self.frequencies)
        steady = np.stack([np.interp(np.linspace(0, at[-1], len(at)), at, one) for one in rest])
        step = at[-1] / (len(at) - 1)
        shape = [np.log(np.abs(np.diff(steady, axis=1)).mean(axis=1)), (steady**3).mean(axis=1),
                 np.log((steady**4).mean(axis=1))]  # fmt: skip
        return np.concatenate([
            two, force[:, :2].mean(axis=0) / level, [np.log(level)], np.log(spread[:, 0] / level),
            np.log(band_means(np.abs(waves) ** 2, FINE) + 1e-6).ravel(), coupling(waves, PAIRS, FINE),
            *(memory(one, one, LAGS * self.spacing / step) for one in steady[:3]),
            *(memory(steady[a], steady[b], SHIFTS * self.spacing / step) for a, b in PAIRS),
            np.corrcoef(steady)[np.triu_indices(4, 1)], *shape,
        ])  # fmt: skip

    def _of_normal(self, at: Floats, normal: Floats) -> Floats:
        """Return the features of the normal channel (n,)."""
        level = normal.mean()
        if not (level > 0 and (normal > FLOOR * level).mean() > 0.5):
            return np.full(len(self.names), np.nan)
        parabola = np.vander(2 * at / at[-1] - 1, 3)
        rest = normal - parabola @ np.linalg.lstsq(parabola, normal, rcond=None)[0]
        spread = rest.std()
        rest = rest / (spread if spread > 0 else np.nan)
        power = np.abs(spectrum(at, rest[None], self.frequencies)) ** 2
        steady = np.interp(np.linspace(0, at[-1], len(at)), at, rest)
        step = at[-1] / (len(at) - 1)
        return np.concatenate([
            np.log([level, spread / level]), np.log(band_means(power, FINE) + 1e-6).ravel(),
            memory(steady, steady, LAGS * self.spacing / step),
            [np.log(np.abs(np.diff(steady)).mean()), (steady**3).mean(), np.log((steady**4).mean())],
        ])  # fmt: skip


def feature_set(kind: str, window: int, slides: Iterable[Slide]) -> FeatureSet:
    """Return the features for slides; their frequencies go from one per window to half the sample rate.

    By way if every slide has a speed, else by time; of the normal channel alone unless every slide has shear.

    Raises:
        InputError: an unknown kind, a window that is too short or too long, or no slide of its length; the two figures
            of slides without shear.
    """
    if kind not in get_args(Kind):
        raise InputError(f"features {kind!r}; {' or '.join(get_args(Kind))} wanted")
    check_most(window, WINDOW, "texture window in samples")
    if window < SHORTEST:
        raise InputError(f"texture window of {window} samples, at least {SHORTEST} wanted")
    long = [one for one in slides if one.t.size >= window]
    if not long:
        raise InputError(f"no slide of {window} samples; longer slides or a shorter window wanted")
    shear = all(one.force[:, :2].any() for one in long)
    if not shear and kind == "figures":
        raise InputError("slides without shear have no friction and no roughness; features 'full' wanted, which use the"
                         " normal channel alone")  # fmt: skip
    by_way = all(one.speed is not None for one in long)
    pace = np.array([one.speed or 1.0 if by_way else 1.0 for one in long])
    spacing = float(np.median([np.median(np.diff(one.t)) for one in long] * pace))
    mean = float(np.median([(one.t[-1] - one.t[0]) / one.t.size for one in long] * pace))
    frequencies = np.geomspace(1 / (mean * window), 0.5 / spacing, BANDS * FINE)
    return FeatureSet("full" if kind == "full" else "figures", window, frequencies, spacing, by_way, shear)
