"""Conversion of device time to host time: a robust line through the least delayed frames.

Frames arrive late, never early. From every quarter of a second of device time only the frame with the smallest
(arrival - device time) counts. The line is that of Theil and Sen: the median of the slopes of all pairs, then the
median of the offsets. A delay of seconds, or of a third of the frames, does not change it.

Source: P. K. Sen, "Estimates of the regression coefficient based on Kendall's tau", JASA 63 (1968) 1379.
"""

from collections import deque

import numpy as np

BIN = 0.25
"""[s] Width of a bin of device time."""
KEPT = 64
"""Number of bins of the line: the last 16 s."""
ENOUGH = 8
"""Number of bins from which the slope is fitted; with fewer it is 1."""
LATE = 0.02
"""[s] Delay behind the line from which a frame counts as late."""
ANEW = 1.0
"""[s] Jump of device time against host time that counts as another clock."""
CHECK, WRONG_RATE, ALL_LATE = 0.1, 8, 30
"""[s] Arrival time between two checks of the clock; number of consecutive checks with a wrong rate, or with more than
half of the frames late, from which the clock is not used."""
OFF = 0.2
"""Relative deviation of the device's second from the host's that is a wrong rate."""


class ClockLine:
    """Maps device time to host time, both in seconds since the start of the stream, from past frames only.

    ``late`` counts frames more than `LATE` behind the line. ``trouble``: why arrivals are returned in place of device
    times; empty while device times are used.
    """

    def __init__(self) -> None:
        self.late = 0
        self.trouble = ""
        self._residuals: deque[float] = deque(maxlen=4096)
        self._latest = 0.0
        self._start_anew()

    def _start_anew(self) -> None:
        self._bins: deque[tuple[float, float]] = deque(maxlen=KEPT)
        self._best: tuple[float, float] | None = None
        self._bin_start = self._last_device = self._last_arrival = float("nan")
        self._slope, self._offset, self._base = 1.0, float("inf"), 0.0
        self._checked: list[tuple[float, float]] = []
        self._late_checks = self._late_frames = self._frames = 0

    def __call__(self, t_device: float, arrival: float) -> float:
        """Return the host time of a frame [s], its arrival without a device clock. It never decreases."""
        if t_device == t_device and not self.trouble:  # NaN: a device without a clock
            step, waited = t_device - self._last_device, arrival - self._last_arrival
            if step < 0:
                self._start_anew()
            elif step - waited > ANEW:
                checked = self._checked
                self._start_anew()
                self._checked = checked
            self._last_device, self._last_arrival = t_device, arrival
            self._collect(t_device, arrival)
            mapped = self._measure(t_device, arrival)
            self._check(t_device, arrival, arrival - mapped > LATE)
            arrival = arrival if self.trouble else min(arrival, mapped)
        self._latest = max(self._latest, arrival)
        return self._latest

    def _check(self, t: float, arrival: float, is_late: bool) -> None:
        """Compare the device's clock with the host's."""
        self._frames += 1
        self._late_frames += is_late
        if self._checked and arrival - self._checked[-1][1] < CHECK:
            return
        self._checked = [*self._checked[-WRONG_RATE:], (t, arrival)]
        device, host = np.diff(self._checked, axis=0).T
        rates = device / host
        self._late_checks = self._late_checks + 1 if 2 * self._late_frames > self._frames else 0
        self._frames = self._late_frames = 0
        if len(rates) == WRONG_RATE and ((rates < 1 - OFF).all() or (rates > 1 + OFF).all()):
            rate = device.sum() / host.sum()
            moves = f"advances {rate:.3g} s in a second of the host" if rate else "stands still"
            self.trouble = f"the device's clock {moves}: frames get the time of their arrival"
        elif self._late_checks >= ALL_LATE:
            self.trouble = (
                f"most frames are more than {LATE:g} s late by the device's clock: they get the time of their arrival"
            )
        if self.trouble:
            self.late = 0
            self._residuals.clear()

    def plain(self) -> dict[str, float | None]:
        """Return the drift [1e-6] and the median, 99th percentile and maximum of the residual [s]; None if unknown."""
        if not self._residuals:
            return {"drift_ppm": None, "residual_median_s": None, "residual_p99_s": None, "residual_max_s": None}
        residual = np.array(self._residuals)
        return {
            "drift_ppm": (self._slope - 1) * 1e6,
            "residual_median_s": float(np.median(residual)),
            "residual_p99_s": float(np.percentile(residual, 99)),
            "residual_max_s": float(residual.max()),
        }

    def _collect(self, t: float, arrival: float) -> None:
        if not t - self._bin_start < BIN:  # also where there is no bin yet
            if self._best is not None:
                self._bins.append(self._best)
                self._fit()
            self._bin_start, self._best = t, (t, arrival)
        elif self._best is None or arrival - t < self._best[1] - self._best[0]:
            self._best = (t, arrival)
        if len(self._bins) < ENOUGH:
            self._offset = min(self._offset, arrival - t)

    def _fit(self) -> None:
        if len(self._bins) < ENOUGH:
            return
        t, arrival = np.array(self._bins).T
        i, j = np.triu_indices(t.size, 1)
        self._base = float(t[-1])
        self._slope = float(np.median((arrival[j] - arrival[i]) / (t[j] - t[i])))
        self._offset = float(np.median(arrival - self._slope * (t - self._base))) - self._base

    def _measure(self, t: float, arrival: float) -> float:
        mapped = self._slope * (t - self._base) + self._base + self._offset
        self._residuals.append(arrival - mapped)
        self.late += arrival - mapped > LATE
        return mapped
