"""Tare of arriving frames: at the start, on request, and automatically while the array is untouched."""

import warnings
from dataclasses import replace
from typing import Literal

import numpy as np

from cnnsim.support import Floats, InputError
from tactile.calibration.gains import Gains
from tactile.calibration.idle_drift import IdleDrift
from tactile.calibration.moved_zero import FRAMES, MovedZero
from tactile.calibration.stillness import MUCH, NEWEST, begins, judge
from tactile.calibration.tare_check import PARTS, TareCheck, TareNote, check_tare
from tactile.calibration.taxel_gains import TaxelGains
from tactile.core.frame import NORMAL, Frame, TaxelArray
from tactile.core.noise import Noise, Steps, early_noise, measured
from tactile.thresholds.threshold import CONTACT, SHEAR

TareMode = Literal["auto", "manual", "off"] | int
SECONDS, SHORT = 0.2, 0.05
"""[s] Shortest block of frames that is judged, and shortest block for the first tare if a load comes before."""
FEW, SLOW = 7, 0.27
"""Least number of frames and least length [s] of the first block of a slow sensor: 25 frames/s."""
IDLE, SLOWLY = "idle", "drift compensation undone by a slow touch"
"""Reasons of an automatic renewal, and of an offset without the drift compensation since a slow touch began."""
CURE = "let nothing touch it, then ask for a tare"
AFTER = 0.1
"""[s] Time after a contact whose frames are not used: silicone creeps back."""


class LiveTare:
    """Subtract an offset from one finger's frames, renew it from still and unloaded blocks, and measure the noise.

    Still: the means of a block's parts differ by more than half of the dead band, and by seven times the taxel's
    jitter, in at most half of the taxels, and by four times that in no taxel that is increasingly pressed. A taxel
    whose silicone creeps back, or that drifts sideways, is left out as too noisy.
    Unloaded: the block's mean is within half a dead band (or three sigma) of the offset. The first block only has
    to be still and to press no more than the first frames did, since no load can be detected yet. A block during or
    just after a contact is not used.
    Idle, the offset of force taxels follows their drift (see `IdleDrift`).

    A still block in which force taxels read a pull has another zero: the sensor was pressed during the tare, or its
    zero moved. The second such block in a row is the new offset, and ``moved`` the time [s] of the fall.

    Until there is an offset no taxel is valid, except in mode "off", where there is none and only the ``noise`` is
    measured; "manual" renews on request only; a number N takes the mean of the first N frames, loaded or not.
    ``gains`` convert the readings to the array's quantity, which is the unit of the dead bands; None if they are in it.
    """

    def __init__(
        self, finger: int, array: TaxelArray, mode: TareMode = "auto", gains: Gains | TaxelGains | None = None,
        seconds: float = SECONDS,
    ) -> None:  # fmt: skip
        self.notes: list[TareNote] = []
        self.noise: Noise | None = None
        self.early: Floats | None = None
        self._finger, self._seconds, self._array, self._gains = finger, seconds, array, gains
        self._frames = 0 if isinstance(mode, str) else mode
        self._mode = "off" if mode == 0 else mode
        if self._frames < 0:
            raise InputError(f"tare over {mode} frames, 0 or more wanted")
        self._limit = np.full(3, SHEAR[array.quantity].dead_band)
        self._limit[NORMAL] = CONTACT[array.quantity].dead_band
        if gains is not None:
            self._limit = gains.readings(self._limit)
        # sign of the normal readings of a pressing load
        self._inward = 1.0 if array.quantity == "force" else -1.0
        if gains is not None:
            self._inward *= np.sign(gains.normal)
        self._drift = IdleDrift(self._limit, self._inward) if array.quantity == "force" else None
        self._offset: Floats | None = np.zeros((*array.shape, 3)) if self._mode == "off" else None
        self._asked = self._forced = self._reported_negative = False
        self._start: Floats | None = None
        self._early_wanted = True
        self._block: list[Floats] = []
        self._times: list[float] = []
        self._zero = MovedZero(self._limit, self._inward) if array.quantity == "force" else None
        self.moved: float | None = None
        self._steps = Steps(array.shape)
        self._since = 0.0
        self._touched = self._renewed = -np.inf

    def touched(self, t: float) -> None:
        """Note a contact at ``t`` [s]. Undo the drift compensation since a taxel rose: it was load."""
        if self._drift is not None and self._offset is not None:
            back = self._drift.give_back(self._offset) if t - self._touched > AFTER else None
            if back is not None:
                self._offset = back
                self.notes.append(TareNote(self._finger, t, SLOWLY, back))
            self._drift.forget()
        self._touched = t

    def ask(self, force: bool = False) -> None:
        """Renew the offset from the next block if it is unloaded, or in any case by ``force``."""
        self._asked, self._forced = True, force
        self._block = []

    def __call__(self, frame: Frame) -> Frame:
        """Return the frame less the offset; readings that are not finite are invalid."""
        if (read := frame.read) is not frame.valid:
            frame = replace(frame, valid=read)
        values = frame.values
        if not frame.whole:
            values = np.where(frame.valid[..., None], values, np.nan)
        if not self._block:
            self._since, self._times = frame.t, []
        self._block.append(values)
        self._times.append(frame.t)
        if self._early_wanted and len(self._block) == 2:
            self._early_wanted = False
            with warnings.catch_warnings(action="ignore", category=RuntimeWarning):  # of taxels without readings
                self.early = early_noise(*self._block)
        counted = self._frames and self._offset is None
        if len(self._block) == self._frames if counted else self._full(frame.t):
            with warnings.catch_warnings(action="ignore", category=RuntimeWarning):  # of taxels without readings
                block = np.array(self._block)
                self._end_block(frame.t, np.where(np.isfinite(block), block, np.nan))  # no offset is infinite
            self._block = []
            if counted:  # the frames that were averaged are not to be used
                return replace(frame, valid=np.zeros_like(frame.valid))
        elif self._offset is None and not counted and self._load_begins(frame.t):
            self._end_first(frame.t)
        if self._offset is None:
            return replace(frame, valid=np.zeros_like(frame.valid))
        if self._mode == "off":
            return frame
        tared, valid = frame.values - self._offset, frame.valid
        finite = np.isfinite(tared)
        if not finite.all():
            valid = valid & finite.all(-1)
        return Frame(frame.finger, frame.t, frame.sequence, tared, valid, frame.t_device)

    def _end_first(self, t: float) -> None:
        """Take the first offset from the frames before an early load, if they were still."""
        with warnings.catch_warnings(action="ignore", category=RuntimeWarning):  # of taxels without readings
            before = np.array(self._block[: -2 * NEWEST])
            before = np.where(np.isfinite(before), before, np.nan)
            if judge(before, measured(before), self._limit, self._inward).still:
                self._end_block(t, before)
                self._block = []

    def _load_begins(self, t: float) -> bool:
        many = len(self._block) - 2 * NEWEST
        if many < FRAMES or many % NEWEST or t - self._since < SHORT:
            return False
        return begins(self._block, self._limit, self._inward)

    def _full(self, t: float) -> bool:
        seconds = t - self._since
        few = FEW if self._offset is None and seconds >= SLOW else FRAMES
        return len(self._block) >= few and seconds >= self._seconds

    def _end_block(self, t: float, block: Floats) -> None:
        mean, noise = np.nanmean(block, axis=0), measured(block).at_least(self._steps.floor)
        what = judge(block, noise, self._limit, self._inward)
        still = what.still
        if still:
            self._steps.see(block)
            noise = noise.at_least(self._steps.floor)
            self.noise = self.noise if self.noise is None else self.noise.at_least(self._steps.floor)
        if self._start is None:
            self._start = what.first
        away = None if self._offset is None else mean - self._offset
        bound = np.maximum(self._limit / 2, 3 * noise.sigma / np.sqrt(FRAMES / 4))
        if away is None:  # a later block is loaded where it presses more than the first frames did
            more = self._inward * (mean - self._start)[..., NORMAL]
            # the noise within the parts: the whole block may include the onset of a load
            slack = np.maximum(self._limit / 2, 3 * what.within)[..., NORMAL]
            loaded = bool((more > MUCH * slack).any())
        else:
            known = np.ones(mean.shape[:2], bool) if self.noise is None else ~self.noise.left_out
            if self._drift is not None:
                bound = np.maximum(bound, self._drift.in_contact(max(self._touched - self._renewed, 0.0)))
            loaded = bool((np.abs(away) > bound)[known].any()) or self._since - self._touched < AFTER
        if self._mode == "off":
            if still and not loaded:
                self._learn(noise)
            return
        first, asked, forced = self._offset is None, self._asked, self._forced
        forced = forced or bool(self._frames and first)
        self._asked = self._forced = False
        if self._zero is not None:
            judged = away if still and self._mode == "auto" and not (asked or forced) else None
            fell = self._zero(self._times, block, judged, noise.sigma)
            if fell is not None and away is not None:
                self._move(t, fell, mean, away, noise)
            if fell is not None or self._zero.fell is not None:
                return
        if not forced and (not still or loaded):
            self._refuse(t, away if away is not None else mean - self._start, still, first or asked, what.far)
        elif first or asked or self._mode == "auto":
            if self._offset is not None and away is not None:
                if self._drift is not None and not (forced or asked) and self._touched <= self._renewed:
                    mean = self._drift.follow(self._offset, away, known, noise.sigma, t - self._renewed)
                # a taxel without readings in this block keeps its offset
                mean = np.where(np.isfinite(mean), mean, self._offset)
            self._offset = mean
            self._renewed = t
            self._reported_negative = False
            why = "at the start" if first else "by force" if forced else "on request" if asked else IDLE
            if still:
                self._learn(noise)
            check = self._check(block, t) if first or asked else None
            detail = "" if check is None else "; ".join([_subtracted(check), *(noise.words() if still else [])])
            self.notes.append(TareNote(self._finger, t, why, self._offset, detail, check if first else None))

    def _move(self, t: float, fell: float, mean: Floats, away: Floats, noise: Noise) -> None:
        """Take another zero, to which the readings fell at ``fell`` [s]."""
        assert self._offset is not None
        amount = check_tare(self._array, self._in_quantity(away)[None], len(self._block), 0.0).amount
        self._offset = np.where(np.isfinite(mean), mean, self._offset)
        self._renewed, self._reported_negative, self.moved = t, False, fell
        self._touched = -np.inf
        self._learn(noise)
        why = f"the zero moved at {fell:.3f} s"
        detail = f"{amount}; a still pull is no load: it is the new zero from {t:.3f} s on"
        self.notes.append(TareNote(self._finger, t, why, self._offset, detail, notice=True))

    def _refuse(self, t: float, away: Floats, still: bool, wanted: bool, far: float) -> None:
        """Report why no offset is taken; if most taxels read a pull, the pad was pressed during the tare."""
        press = self._inward * away[..., NORMAL]
        limit = self._limit[..., NORMAL]
        negative = bool((press < -limit).sum() * 2 > (press > 0).sum() + 1)
        negative = negative and float(np.nansum(press)) < -2 * float(np.median(limit))
        if wanted or (negative and still and not self._reported_negative):
            why, detail = "moving", f"means move {far:.2g} times the limit of noise and drift: {CURE}"
            if still:
                amount = check_tare(self._array, self._in_quantity(away)[None], len(self._block), 0.0).amount
                why, detail = "loaded", f"{amount} off the tare: {CURE}"
            if negative and still:
                detail = f"{amount} off the tare: it was pressed during the tare; t! tares it by force"
                self._reported_negative = True
            self.notes.append(TareNote(self._finger, t, f"refused: {why}", None, detail))

    def _learn(self, noise: Noise) -> None:
        self.noise = noise.and_before(self.noise)

    def _check(self, block: Floats, t: float) -> TareCheck:
        parts = np.array([np.nanmean(part, axis=0) for part in np.array_split(block, min(PARTS, len(block)))])
        return check_tare(self._array, self._in_quantity(parts), len(block), t - self._since)

    def _in_quantity(self, readings: Floats) -> Floats:
        return readings if self._gains is None else self._gains(readings)


def _subtracted(check: TareCheck) -> str:
    """Return how much was subtracted, with a warning if it may be a load."""
    amount = f"{check.amount} subtracted"
    return f"{amount}; loaded, or an offset of that size: {CURE}" if check.loaded else amount
