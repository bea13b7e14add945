"""Fit: point loads least squares to the signals of all taxels, and what they leave unexplained."""

import math
from functools import cached_property
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from cnnsim.support import Floats

STEPS = 20
"""Gauss-Newton steps at most; two or three are usual."""
MANY = 25
"""From that many taxels the noise is read off the residual where it is not given."""
TIED = 1e9
"""What holds shear at zero where the taxels cannot tell it."""
USUAL = 0.01
"""Noise of a taxel over its largest signal."""
SMALL = 2.5e-3
"""Where so much is left of the energy, nobody asks how much of it is noise."""
CHANCE = 2.0
"""Standard deviations of a sum of squares that are chance."""
SURELY_NONE = 3.0
"""Standard deviations of a sum of squares above which it is no noise: chance goes so far in one frame of 100 to 300."""

FOREIGN = 0.01, 2.0, 30.0
"""What is left at a taxel out of reach is of another load if it is so large a part of the largest signal, so many times
what the loads make there, and in squares so many times the median taxel's. Within reach, and everywhere a little, wide
tips and thin covers leave as much."""
SURELY = 6.0
"""Standard deviations of a signal that a taxel does not feel by chance."""
SLIGHT = 2e-3
"""From this misfit on a false reading may be to blame: it has moved a place by a tenth of a depth."""
LEAST_FREE = 6
"""So few degrees of freedom let chance explain all the rest, where nobody knows the noise."""
HUNG_ON = 0.9
"""Of so large a part of an error in one reading, which the load takes for its own, the first order says little."""
SAME = 0.1
"""Places nearer than so many depths are one place."""
REACH, ALL = 4.0, 100
"""Of more than so many taxels those within so many depths are fitted: the others feel a hundredth at most."""


class Signals(NamedTuple):
    """What the taxels of one frame feel: places (n, 2) in depths, signals (n, 3) over the largest of them.

    The signals come times ``scale`` (n, 3), which makes their noise equal; ``noise``: its standard deviation, None
    where it is not known. ``layer``: table of `layer_field`, empty for the half-space. ``tie`` (3,) holds shear at zero
    in the directions that these taxels cannot tell; they are the taxels ``cells`` (n,) of an array of ``shape``.
    ``lost``: how many signals are left out; they and their scale are 0.
    """

    seen: Floats
    felt: Floats
    scale: Floats
    strain: bool
    layer: Floats
    tie: Floats
    cells: NDArray[np.intp]
    shape: tuple[int, int]
    noise: float | None
    lost: int = 0

    def without(self, k: int) -> "Signals":
        """The signals of all taxels but the k-th."""
        seen, felt, scale = (np.delete(part, k, 0) for part in (self.seen, self.felt, self.scale))
        lost = self.lost - int((self.scale[k] == 0).sum())
        return self._replace(seen=seen, felt=felt, scale=scale, cells=np.delete(self.cells, k), lost=lost)


class Fit:
    """The loads (k, 5) nearest to the signals, in depths and as signals are.

    ``chi``: sum of the squares that they leave of ``whole``; ``spread`` (k, 5): variances for signals of variance 1;
    ``free``: degrees of freedom, signals less what was fitted to them; ``variance`` of a signal: that of the noise
    where it is known, more where the residual says more, NaN without. ``stranger``: the taxel out of reach of the loads
    where they leave most, -1 for none.
    """

    def __init__(
        self, signals: Signals, loads: Floats, chi: float, whole: float, spread: Floats, stranger: int
    ) -> None:
        self.signals, self.loads, self.chi, self.whole, self.spread = signals, loads, chi, whole, spread
        self._stranger = stranger
        xx, xy, yy = signals.tie.tolist()
        told = 2 if xx + yy == 0 else int(xx * yy - xy * xy <= 1e-12 * (xx + yy) ** 2)
        self.free = max(signals.felt.size - signals.lost - (3 + told) * len(loads), 0)
        left, noise = chi / self.free if self.free else math.nan, signals.noise
        self.variance = left if noise is None or left > noise * noise else noise * noise

    @cached_property
    def rest(self) -> Floats:
        """The signals (n, 3) that the loads leave unexplained."""
        from tactile.inverse.least_squares import equations_numba  # numba is slow to import

        signals = self.signals
        return equations_numba.rest(
            signals.seen, signals.felt, signals.scale, self.loads, signals.strain, signals.layer
        )

    def made(self, signals: Signals) -> Floats:
        """The signals (n, 3) of the loads, to taxels at the same places."""
        return made(signals, self.loads)

    @cached_property
    def foreign(self) -> int | None:
        """The taxel out of reach that feels most of what none of the loads makes, None where none does."""
        if self._stranger < 0:
            return None
        from tactile.inverse.least_squares.noise_numba import stands_out  # as above

        return self._stranger if stands_out(self.rest, self._stranger, FOREIGN[2]) else None

    @cached_property
    def random(self) -> float:
        """The part of chi that is noise, with what chance may add to it."""
        noise = self.signals.noise
        if noise is None and (self.chi < SMALL * self.whole or len(self.signals.seen) < MANY):
            return 0.0
        if noise is None:
            from tactile.inverse.least_squares.noise_numba import read_noise  # as above

            rows, cols = self.signals.shape
            return float(read_noise(self.rest, self.signals.felt, self.signals.cells, rows, cols, self.chi, CHANCE))
        return noise * noise * (self.free + CHANCE * math.sqrt(2 * self.free))

    @cached_property
    def misfit(self) -> float:
        """Share of the signals, as root mean squares, that neither the loads nor the noise explain."""
        signal = max(self.whole - self.random, self.random / len(self.signals.seen))
        return math.sqrt(min(max(self.chi - self.random, 0.0) / signal, 1.0)) if signal else 0.0

    @cached_property
    def excess(self) -> float:
        """The part of chi that surely is no noise; 0 where nobody knows or can tell the noise."""
        noise = self.signals.noise
        if noise is None:
            return max(self.chi - self.random, 0.0) if self.random > 0 else 0.0
        return max(self.chi - noise * noise * (self.free + SURELY_NONE * math.sqrt(2.0 * self.free)), 0.0)

    @cached_property
    def unexplained(self) -> tuple[Floats, float, float, int]:
        """Variances (k, 5) of the loads, in depths and as signals are, for what is left beyond the noise.

        Beside them what `reliability_numba.unexplained` says of single readings: of one load alone it is asked.
        """
        from tactile.inverse.least_squares import reliability_numba  # numba is slow to import

        signals, excess = self.signals, self.excess
        if len(self.loads) > 1:
            return excess * self.spread, 0.0, 0.0, 0
        more = np.empty((1, 5))
        said = reliability_numba.unexplained(
            signals.seen, signals.felt, signals.scale, self.loads[0], signals.strain, signals.layer, signals.tie,
            signals.noise or 0.0, self.chi, excess, self.free, self.spread[0], STEPS, more[0],
        )  # fmt: skip
        return more, *said

    @property
    def unsure(self) -> float:
        """Standard deviation of the first load's place in depths, noise of a hundredth assumed where it is unknown."""
        deviation = math.sqrt(self.variance)
        if self.signals.noise is None and not deviation > USUAL:
            deviation = USUAL
        return deviation * math.sqrt(max(self.spread[0, :2].tolist()))

    def off(self, k: int) -> float:
        """Standard deviation of the k-th load's place in depths, with what the loads leave unexplained."""
        chance, left = self.variance * self.spread[k, :2], self.unexplained[0][k, :2]
        return math.sqrt(float((chance + np.maximum(left, 0.0)).max()))

    @cached_property
    def contrary(self) -> NDArray[np.intp]:
        """The taxels by what they leave unexplained, the worst first."""
        return np.argsort(-(self.rest**2).sum(axis=1), kind="stable")


def fitted(signals: Signals, start: Floats) -> Fit:
    """Return the fit from a start on: loads (k, 5), or the place (1, 2) of one, whose forces the signals tell there."""
    from tactile.inverse.least_squares import components_numba, doubt_numba, equations_numba, fit_numba  # as above

    loads = np.zeros((len(start), 5))
    loads[:, : start.shape[1]] = start
    parts = fit_numba.near(signals.seen, signals.felt, signals.scale, loads, REACH, ALL, MANY)
    if start.shape[1] == 2:
        components_numba.components(*parts, loads[0], signals.strain, signals.layer, signals.tie)
    chi, whole, spread = fit_numba.fit(*parts, loads, signals.strain, signals.layer, signals.tie, STEPS)
    seen, felt, least = signals.seen, signals.felt, least_foreign(signals.noise)
    rest = equations_numba.rest(seen, felt, signals.scale, loads, signals.strain, signals.layer)
    stranger = doubt_numba.foreign(seen, rest, felt, loads, REACH, least, FOREIGN[1])
    if len(parts[0]) < len(seen):
        chi, whole = equations_numba.energy(rest), equations_numba.energy(felt)
    found = Fit(signals, loads, chi, whole, spread, stranger)
    found.__dict__["rest"] = rest  # as `cached_property` keeps it
    return found


def made(signals: Signals, loads: Floats) -> Floats:
    """Return the signals (n, 3) of loads (k, 5), to taxels at the places of these signals."""
    from tactile.inverse.least_squares import equations_numba  # as above

    nothing = np.zeros_like(signals.felt)
    return -equations_numba.rest(signals.seen, nothing, signals.scale, loads, signals.strain, signals.layer)


def least_foreign(noise: float | None) -> float:
    """Return what a taxel out of reach feels at least of another load."""
    return max(FOREIGN[0], SURELY * (noise or 0.0))
