"""Motor noise: bursts of a tone in all channels, from the magnetic field of a stepper motor."""

from collections.abc import Iterable, Iterator
from dataclasses import replace

import numpy as np

from tactile.simulator.batch import Batch
from tactile.simulator.effect import effect, parameter


@effect("frames", random=True)
class MotorNoise:
    """A tone of ``frequency`` [Hz] and ``amplitude`` (of full scale) that comes and goes in bursts.

    Bursts last ``burst`` [s] on average and fill a share ``duty`` of the time; both they and the pauses are
    exponentially distributed, from a stationary start. Every channel of the finger has the same tone, sampled at the
    frames' times (aliased). Mean 0, mean square amplitude^2 duty / 2.

    Source: Vasarhelyi, Fodor, Roska, sect. 4.1; 0.5 mm/s at 320 steps a millimetre are 160 steps a second.
    """

    amplitude: float = parameter(0.005, none=0.0)
    frequency: float = parameter(1600.0, key="frequency_hz")
    duty: float = parameter(0.2, 0.0, 1.0)
    burst: float = parameter(0.1, 1e-6, key="burst_s")

    def __call__(self, stream: Iterable[Batch], random: np.random.Generator) -> Iterator[Batch]:
        """Frames with the tone."""
        if self.duty == 0:
            yield from stream
            return
        phase = random.uniform(0, 2 * np.pi)
        running = bool(random.uniform() < self.duty)
        pause = self.burst * (1 - self.duty) / self.duty
        until, started = -np.inf, False
        for batch in stream:
            gate = np.zeros(len(batch.t))
            for n, t in enumerate(batch.t.tolist()):
                if not started:
                    until, started = t + random.exponential(self.burst if running else pause), True
                while t >= until:
                    running = not running
                    until += random.exponential(self.burst if running else pause) if self.duty < 1 or running else 0.0
                gate[n] = running
            tone = gate * self.amplitude * batch.full_scale * np.sin(2 * np.pi * self.frequency * batch.t + phase)
            yield replace(batch, values=batch.values + tone[:, None, None, None])
