"""Finger: what has to be remembered of one array between frames, and what one frame does to it."""

from dataclasses import dataclass, replace
from math import isfinite
from typing import TYPE_CHECKING

import numpy as np

from cnnsim import InputError
from cnnsim.program.file import load_program
from cnnsim.program.machine import UniversalMachine
from cnnsim.program.program import Program
from tactile.calibration.gains import Gains, Tare
from tactile.core.frame import Frame, TaxelArray
from tactile.events.code import CONTACT, SHEAR, Threshold, encode, encode_values
from tactile.events.comparators import Comparators
from tactile.events.events import load_meaning, meaning, slip_meaning
from tactile.events.slip import SlipWatch
from tactile.inverse.localise import Load, localise
from tactile.texture.figures import Texture, TextureFigures

if TYPE_CHECKING:
    from tactile.calibration.radial import RadialCorrection


@dataclass(frozen=True)
class Settings:
    """What a user can choose; None means: as the array's quantity asks for.

    ``shear`` and ``contact`` thresholds in the unit of the signal; ``window`` T [frames] and ``floor`` (normal signal)
    of the texture figures; ``tare`` frames at the start that are averaged away; ``gains`` from readings to the array's
    quantity, eq. (15); ``depth`` [m] to locate with and ``radial`` correction of what a taxel locates, as a scan
    measured them; ``backend`` of the machine.
    """

    shear: Threshold | None = None
    contact: Threshold | None = None
    window: int = 128
    floor: float | None = None
    tare: int = 0
    gains: Gains | None = None
    depth: float | None = None
    radial: "RadialCorrection | None" = None
    backend: str = "cpu"


class Finger:
    """One array with its tare, its inverse, its comparators, its slip watch and its texture figures."""

    def __init__(self, array: TaxelArray, modulus: float | None, settings: Settings) -> None:
        contact = settings.contact or CONTACT[array.quantity]
        shear = settings.shear or SHEAR[array.quantity]
        machine = UniversalMachine(settings.backend, "float64")
        self.array = array = array if settings.depth is None else replace(array, depth=settings.depth)
        self._shear, self._contact = shear, contact
        self._tare, self._gains, self._radial = Tare(settings.tare), settings.gains, settings.radial
        self.taxels = Comparators(machine, array.shape, shear, contact)
        self._load = Comparators(machine, (1, 1), SHEAR["force"], CONTACT["force"])
        self._slip = SlipWatch()
        self._texture = Texture(settings.window, contact.dead_band if settings.floor is None else settings.floor)
        self._machine, self._inverse = machine, _inverse(array, modulus, contact.dead_band)
        self._positions = array.positions()

    def calibrate(self, raw: Frame) -> Frame:
        """Return the frame less its tare, times the gains."""
        frame = self._tare(raw)
        return frame if self._gains is None else replace(frame, values=self._gains(frame.values))

    def locate(self, frame: Frame) -> Load | None:
        """Return the load under this finger: the inverse in every cell, then the taxels' consensus.

        None for arrays that measure force themselves.
        """
        if self._inverse is None:
            return None
        values = np.where(frame.valid[..., None], frame.values, np.nan)
        signals = {name: values[..., i] for i, name in enumerate(self._inverse.inputs)}
        planes = tuple(self._machine.run(self._inverse, **signals).values())
        if self._radial is not None:
            planes = tuple(plane for k in range(0, len(planes), 4) for plane in self._radial(planes[k : k + 4]))
        return localise(self._positions, planes[:4], planes[4:] or None, self.array.depth)

    def notice(self, frame: Frame, load: Load | None) -> list[str]:
        """Run the comparators on the frame and return in words what has changed."""
        happened = []
        if self.taxels.update(encode(frame, self.array.quantity, self._shear, self._contact)):
            happened.append(meaning(self.taxels.before, self.taxels.code))
        if load is not None:
            whole = np.array([[[part if isfinite(part) else 0.0 for part in (load.Q, load.R, load.F)]]])
            if self._load.update(encode_values(whole, "force", SHEAR["force"], CONTACT["force"])):
                happened += load_meaning(self._load.before, self._load.code, load)
            slip = self._slip.update(frame.t, load, bool(self.taxels.code.contact.any()))
            happened += [slip_meaning(slip)] if slip else []
        return happened

    def feel(self, frame: Frame) -> TextureFigures:
        """Return the texture figures after this frame."""
        return self._texture.update(np.where(frame.valid[..., None], frame.values, np.nan))


def _inverse(array: TaxelArray, modulus: float | None, floor: float) -> Program | None:
    if array.quantity == "force":
        return None
    if array.quantity == "stress":
        return load_program("locate-stress", parameters={"depth": array.depth, "floor": floor})
    if modulus is None:
        raise InputError(
            f"taxel array {array.name!r} measures strain; the cover's Young's modulus is wanted, none is given"
        )
    return load_program("locate-strain", parameters={"depth": array.depth, "modulus": modulus, "floor": floor})
