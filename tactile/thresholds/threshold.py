"""Dead bands with hysteresis: their comparator cells, and the default thresholds."""

from dataclasses import dataclass

from cnnsim import InputError, Template
from cnnsim.support.keywords import spelled_class
from cnnsim.support.values import is_number
from tactile.core.frame import Quantity


@spelled_class
@dataclass(frozen=True)
class Threshold:
    """A dead band with hysteresis [unit of the signal]: on above ``dead_band + hysteresis``, off below ``dead_band``.

    With both 0 it is the bare sign, which keeps its state at exactly 0.

    Raises:
        InputError: a negative or infinite number.
    """

    dead_band: float
    hysteresis: float

    def __post_init__(self) -> None:
        for name in ("dead_band", "hysteresis"):
            value = getattr(self, name)
            if not is_number(value) or not 0 <= value < float("inf"):
                raise InputError(f"{name} is {value!r}; a number from 0 wanted")
            object.__setattr__(self, name, float(value))

    @property
    def full_scale(self) -> float:
        """Signal of CNN value 1; larger signals are clipped without effect on any comparator."""
        return 4 * (self.dead_band + self.hysteresis) or 1.0

    def comparator(self, sign: int = 1) -> Template:
        """Return the cell that compares ``sign`` times its input with this threshold; its state must be kept.

        A = 2 holds y = -1 until B u + z > 1 and y = +1 until B u + z < -1. With on, off in units of full scale
        B = 2 / (on - off) and z = -(on + off) / (on - off). Without hysteresis A = 1, B = 1, z = -dead band.
        """
        off = self.dead_band / self.full_scale
        if self.hysteresis == 0:
            return Template([[1]], [[sign]], -off, "comparator")
        width = self.hysteresis / self.full_scale
        return Template([[2]], [[sign * 2 / width]], -(2 * off + width) / width, "comparator")


SIGN = Threshold(0.0, 0.0)
"""The paper's code: the bare sign of each shear component (section 6)."""

SHEAR: dict[Quantity, Threshold] = {
    "force": Threshold(0.1, 0.05),
    "strain": Threshold(1e-3, 5e-4),
    "stress": Threshold(2e3, 1e3),
}
"""Default thresholds of shear [N, 1, Pa]."""

CONTACT: dict[Quantity, Threshold] = {
    "force": Threshold(0.05, 0.025),
    "strain": Threshold(1e-3, 5e-4),
    "stress": Threshold(2e3, 1e3),
}
"""Default thresholds of the normal component [N, 1, Pa]."""
