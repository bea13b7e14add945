"""Signals of a finger: planes per taxel and scalars of the total load, as CNN values, updated per frame."""

from math import inf, isfinite

import numpy as np

from cnnsim.support import Flags, Floats
from tactile.core.frame import Frame, Quantity
from tactile.core.noise import Noise
from tactile.events.signals.held_load import HeldLoad
from tactile.events.signals.names import BALANCED, DROPPING, LEVELS, LOOSENED, PLANES, RISING, SETTLED, TURNING
from tactile.inverse.load import Load
from tactile.inverse.validity import Validity
from tactile.thresholds.levels import Levels

FAST, SLOW = 0.01, 0.2
"""[s] Time constants of the two means of a taxel; a change is the fast mean minus the slow one."""
LOAD = (0.004, 0.015, 0.1, 1.0, 0.05, 0.08)
"""[s] Time constants of the total load: three means, (the factor of the held load), the unsteadiness; and the slow mean
while the load is unsteady."""
KEPT = 16
"""Number of state variables of `step_numba.step`."""
DRAWN = 9.0
"""Threshold of an unexplained change of shear [sigma]; every taxel is tested in every frame."""
TAUS = tuple(0.003 * 1.15**k for k in range(23))
"""[s] Time constants of the growth of the pull, to 65 ms; the shortest that noise allows is used. Coarser steps would
delay a light grasp by 2.7 of the next time constant."""
DRIFT = np.array([90.0, 90.0, 23.0])
"""Largest drift of an unpressed taxel in levels: 1 N of shear, 0.5 N of pressing at noise of 1.1 and 3.6 mN."""
COMMON, FASTEST = 1.2, 3.5
"""Fastest common drift in levels of pressing per second without and with a contact: 25 and 75 mN/s at this noise."""
UNKNOWN = np.array([0.011, 0.011, 0.022])
"""Those levels [N] while the noise is unknown."""
HELD_LOAD, HELD_FACTOR = 3, 5
"""Index of the held load in the state of `step_numba.step`, and of its factor in the time constants."""
LITTLE_LEFT = 0.05
"""Part of the load below which the remaining taxels cannot stand for the held load."""
UNEXPLAINED = 0.9
"""Misfit above which a located load counts as no load: a fit to pure noise leaves 0.93 to 0.99 of it."""
WITHIN = 5.0
"""Standard deviations below which all forces of a load are noise: 4.4 is the largest of 16384 places."""

ALWAYS = np.ones((1, 1), bool)
ONE = Levels(np.full((1, 1, 3), 0.01), np.full((1, 1, 3), 0.015))
"""Levels [N] of a located load as a taxel; only scalars and drawn shear are used."""


class Signals:
    """Seven planes and fifteen scalars of one finger, updated with every frame.

    Planes (rows, cols), binary scale (1/6: comparator off, 1/4: on): ``shear_x``, ``shear_y``, ``pressing``: reading
    over the levels of the taxel; for shear, levels of at least 2 % of its pressing. ``drawn_x``, ``drawn_y``: change of
    the shear s that the change of the normal n does not explain, ds - (s/n) dn. d is the mean of 10 ms (at least two
    frames) minus that of 200 ms (80 ms while the load is unsteady). It is ds alone where shear is most of the change.
    They are on from 9 sigma and 1.6 % of the typical load of a taxel, or, on pressed taxels, where the same quantity of
    all taxels together is on: from 6 sigma, 3 % of F and 30 % of the largest recent change of the total shear, where it
    exceeds its own mean. ``share``: shear of a taxel along the total shear over its pressing, over the same ratio of
    the rim; equal for all taxels in full slip. It is 1/4 from 0.9 on, -1/4 from 0.82 down (or 1.5 and 4.5 sigma), of
    the 3 x 3 neighbourhood where sigma is above 0.04, and 0 where noise leaves it undecided. ``firmness``: slow mean of
    pressing over three times its levels, or fast mean over five times.

    Scalars of the total normal load F (sum over the taxels), binary scale: ``loaded`` F over its noise; ``rising`` F
    over its mean of 100 ms (25 %); ``falling`` the fall from the mean of 15 ms to that of 4 ms (1.5 % of the held
    load); ``loosened`` and ``settled``: see `HeldLoad`; ``unsteady`` difference of F from its mean of 100 ms (3 %);
    ``sheared`` whether shear changes by more than about half of the pressing (sums of squares over the taxels, 0.3),
    ``outweighs`` and by more than noise (6 variances);
    ``driven`` change of the total shear (mean of 10 ms minus that of 200 ms) over 6 sigma and 0.4 % of F;
    ``dropping`` a fall of 4 %, as when a gripper opens; ``yielding`` growth of Q/F over its fastest of the last 0.5 s
    (on below 0.25, off above 0.4): a contact that slides as a whole stops following; ``sticking`` part of F on sticking
    taxels (on above 0.15, off below 0.1); ``turning``, ``turning_back`` torque about the centre of pressure of the
    shear that the pressing does not explain, clockwise and anticlockwise in the picture (0.7 of its possible value, 6 %
    of F times the radius of gyration); ``balanced`` whether both are off, force taxels only.

    In strain the pressing of a point load sums to 0 over the plane, so F is the sum over the pressed taxels only.
    """

    def __init__(self, shape: tuple[int, int], quantity: Quantity) -> None:
        from tactile.events.signals.drift_numba import flat, follow  # numba is slow to import
        from tactile.events.signals.onset_numba import KEPT as FRAMES
        from tactile.events.signals.onset_numba import bend, remember  # the same
        from tactile.events.signals.sliding_numba import slide  # the same
        from tactile.events.signals.step_numba import GROWS, step  # the same
        from tactile.events.signals.turn_numba import turn  # the same

        self._step, self._slide, self._turn, self._remember, self._bend = step, slide, turn, remember, bend
        self._flat, self._held, self._begun, self._hold = flat, np.zeros(shape), 0.0, HeldLoad()
        self._follow, self._base, self._common = follow, np.zeros((*shape, 3)), np.zeros(3)
        self._less = np.zeros((*shape, 3))
        self._allow_drift(UNKNOWN)
        self.planes = np.zeros((len(PLANES), *shape))
        self.levels = np.zeros(len(LEVELS))
        self.force = 0.0
        self._inward, self._rectify = 1.0 if quantity == "force" else -1.0, quantity == "strain"
        self._fast, self._slow, self._scalars = np.zeros((*shape, 3)), np.zeros((*shape, 3)), np.zeros(KEPT)
        self._taps = np.array([FAST, SLOW, *LOAD])
        self._t: float | None = None
        self._interval = FAST
        self._drawn, self._quiet = np.zeros(shape), np.zeros((3, *shape))
        self._counts, self._left_out = np.ones(shape, bool), np.zeros(shape, bool)
        self._taus, self._growth = np.array(TAUS), np.zeros(2 * len(TAUS) + 4)
        self._shares = quantity == "force" and self._counts.size > 1  # located loads: a slip is a travel of the load
        self._one = np.zeros((1, 1, 3))
        self._times, self._past, self._next = np.zeros(FRAMES), np.zeros((FRAMES, *shape, 3)), np.zeros(2, np.int64)
        self._series, self._hinges = np.zeros((2, FRAMES)), np.zeros((FRAMES, FRAMES))
        self._load, self._grows = self, GROWS

    def set_noise(self, noise: Noise | None, levels: Levels) -> None:
        """Set the noise after the filters and the threshold of an unexplained change."""
        if noise is None or not noise.sigma.any():
            self._quiet[:] = 0
            self._drawn = levels.on[..., :2].max(axis=-1)
            self._allow_drift(UNKNOWN)
            return
        if self._counts.any():
            self._allow_drift(np.median(levels.on[self._counts], axis=0))
        keep = 1 - np.exp(-self._interval / max(FAST, 2 * self._interval))
        left = np.sqrt(noise.jitter**2 * keep / (2 - keep) + noise.slow**2)
        self._quiet = np.stack([left[..., :2].max(axis=-1), left[..., 2], noise.jitter[..., :2].max(axis=-1)])
        self._drawn = DRAWN * self._quiet[0]

    def leave_out(self, left_out: Flags) -> None:
        """Set the taxels (rows, cols) that do not count; the loads go on with the share of the others."""
        if left_out is self._left_out:
            return
        self._left_out, counts = left_out, ~left_out
        if not np.array_equal(counts, self._counts):
            press = np.maximum(self._fast[..., 2], 0.0)
            before, now = float(press[self._counts].sum()), float(press[counts].sum())
            if before > 0 and now > LITTLE_LEFT * before:
                self._scalars[: HELD_LOAD + 1] *= now / before
            self._counts = counts

    def _allow_drift(self, level: Floats) -> None:
        self._most, self._fastest = DRIFT * level, np.outer((COMMON, FASTEST), np.full(3, level[2]))

    def update(self, frame: Frame, use: Flags, levels: Levels, contact: bool = False) -> None:
        """Process a frame; ``use`` (rows, cols) marks usable taxels, ``levels`` are those of their comparators.

        In a ``contact`` the drift of unpressed force taxels is subtracted.
        """
        values = frame.values
        if self._shares:
            dt = max(frame.t - self._t, 0.0) if self._t is not None else 0.0
            self._follow(
                values, self._fast, use, levels.off, levels.on, self._most, self._fastest[int(contact)], dt, contact,
                self._common, self._base, self._less,
            )  # fmt: skip
            values = self._less
            if not contact:
                self._begun = frame.t
        self._update(frame.t, values, use, levels, contact)

    def forget_drift(self, taken: Floats) -> None:
        """Remove from the drift estimate what a new offset contains; it changed by ``taken`` (rows, cols, 3)."""
        self._base[:] = 0.0
        common, part = self._common, np.nan_to_num(np.nanmedian(taken.reshape(-1, 3), axis=0))
        common -= np.clip(part, np.minimum(common, 0.0), np.maximum(common, 0.0))  # at most the drift that was followed

    def _update(self, t: float, values: Floats, use: Flags, levels: Levels, contact: bool) -> None:
        dt = 0.0 if self._t is None else max(t - self._t, 0.0)
        self._interval += 0.05 * (dt - self._interval)
        self._t = t
        self._taps[HELD_FACTOR] = follows = self._hold.follows(dt, contact)
        self._step(
            values, use, self._counts, self._inward, self._rectify, dt, levels.off, levels.on, self._drawn,
            self._quiet[0], self._quiet[1], self._fast, self._slow, self._scalars, self._taps, self.planes, self.levels,
        )  # fmt: skip
        alike = 0.0
        if self._shares:
            self._slide(
                values, self._fast, use, self._quiet[2], self._quiet[0], self._quiet[1], dt, self._interval,
                self._taus, self._growth, self.levels[RISING] > 0.25, self.planes, self.levels,
            )  # fmt: skip
            most = min(self._fastest[1, 0] * (t - self._begun), self._most[2])
            alike = self._flat(self._fast, self._held, use, follows, most)
            turn = self._turn(self._fast, self._slow, use, self._quiet[0], self._quiet[1])
            self.levels[TURNING], self.levels[TURNING + 1], self.levels[BALANCED] = turn, -turn, 5 / 12 - abs(turn)
        force, held = self._scalars.item(0), self._scalars.item(HELD_LOAD)
        self._hold.update(t, force - alike, max(held, alike), self._interval, self.unrest < 1.5, contact)
        self.levels[LOOSENED], self.levels[SETTLED] = self._hold.loosened, self._hold.settled
        if self.levels[RISING] > 0.25 or self.levels[DROPPING] > 0.25:
            self._next[:] = 0  # shear of a closing or opening grip is not the onset of a pull
        else:
            self._remember(t, self._fast, self._times, self._past, self._next)
        self.force = force

    @property
    def late(self) -> float | None:
        """Delay [s] of the growth of the pull when it was reported: 2.5 tau of its two filters.

        After a sudden stop the filtered growth, (1 + t/tau) exp(-t/tau) of its former value, is below 0.25 after 2.7
        tau. Where it yields gradually, as a longer filter shows, there is no delay. None where the growth is not
        observed.
        """
        return float(2.5 * self._growth[-1]) if self._shares else None

    def drawn_since(self, t: float) -> float:
        """Return the onset [s] of the shear that is drawn now; ``t`` if unknown."""
        load = self._load
        if load._t is None:
            return t
        moved, pressed, of_late = load._scalars[[8, 9, 15]]
        explained = not (moved > 0.25 * pressed and moved > self._grows * of_late)
        late = max(FAST, 2 * load._interval)
        bent = load._bend(
            load._t, load.planes[3:5], load._slow, explained, load._times, load._past, load._next, load._series,
            load._hinges,
        )  # fmt: skip
        return bent - late

    @property
    def unrest(self) -> float:
        """Unsteadiness of the total normal load: 1 at 4 %, the largest of the last 50 ms."""
        return float(self._scalars[10])

    def take_load(self, t: float, load: Load, contact: bool) -> None:
        """Process a located load as one force taxel; no load is 0 N, an unknown load keeps the last value."""
        lost = load.validity is Validity.NO_LOAD or load.misfit > UNEXPLAINED or _is_noise(load)
        self._one[0, 0] = (0.0, 0.0, 0.0) if lost else (load.Q, load.R, load.F)
        if not lost:
            _, _, of_q, of_r, of_f = load.scatter
            if isfinite(of_q + of_r + of_f):
                keep = (self._interval / (self._interval + 2 * FAST)) ** 0.5
                shear, normal = self._quiet.item(0), self._quiet.item(1)  # floats: faster than arrays of one cell
                self._quiet[0, 0, 0] = shear = shear + 0.1 * (max(of_q, of_r) * keep - shear)
                self._quiet[1, 0, 0] = normal + 0.1 * (of_f * keep - normal)
                self._drawn[0, 0] = DRAWN * shear
        self._update(t, self._one, ALWAYS, ONE, contact)

    def put_load(self, load: "Signals") -> None:
        """Copy scalars and drawn shear of the located load: shear strain alone is no tangential load."""
        self.planes[3:5] = load.planes[3:5]
        self.planes[5] = 0.0
        self.levels[:] = load.levels
        self._load = load

    @property
    def shear(self) -> tuple[float, float]:
        """Total tangential load after 10 ms, in the unit of the signal."""
        return float(self._scalars[5]), float(self._scalars[6])


def _is_noise(load: Load) -> bool:
    """Return whether the forces of a load are known to be no larger than their noise."""
    forces = zip((load.Q, load.R, load.F), load.scatter[2:], strict=True)
    return all(abs(force) <= WITHIN * sigma < inf for force, sigma in forces)
