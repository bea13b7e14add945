"""Motor noise: the stepper motor's magnetic field, bursts of a high-frequency tone in all channels."""

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, replace
from typing import Any, ClassVar

import numpy as np

from tactile.simulator.batch import Batch
from tactile.simulator.checks import within


@dataclass(frozen=True)
class MotorNoise:
    """A tone of ``frequency`` [Hz] and ``amplitude`` (of full scale) that comes and goes in bursts.

    Bursts last ``burst`` [s] on average and fill a share ``duty`` of the time; both they and the pauses are
    exponentially distributed, and the scene starts anywhere among them. Every channel of the finger sees the same
    tone, sampled at the frames' times (it folds down). Mean 0, mean square amplitude^2 duty / 2.

    Source: Vasarhelyi, Fodor, Roska, sect. 4.1; 0.5 mm/s at 320 steps a millimetre are 160 steps a second.
    """

    amplitude: float = 0.005
    frequency: float = 1600.0
    duty: float = 0.2
    burst: float = 0.1

    STAGE: ClassVar[str] = "frames"
    RANDOM: ClassVar[bool] = True
    KEYS: ClassVar[Mapping[str, tuple[str, float]]] = {
        "amplitude": ("amplitude", 1.0),
        "frequency_hz": ("frequency", 1.0),
        "duty": ("duty", 1.0),
        "burst_s": ("burst", 1.0),
    }
    NONE: ClassVar[Mapping[str, Any]] = {"amplitude": 0.0}

    def __post_init__(self) -> None:
        within("amplitude", self.amplitude)
        within("frequency", self.frequency)
        within("duty", self.duty, 0.0, 1.0)
        within("burst", self.burst, 1e-6)

    def __call__(self, stream: Iterable[Batch], random: np.random.Generator) -> Iterator[Batch]:
        """Frames with the tone."""
        if self.amplitude == 0 or self.duty == 0:
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
