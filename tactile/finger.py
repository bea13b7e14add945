"""Finger: the state of one taxel array between frames, and the stages of the pipeline that a frame passes."""

from dataclasses import replace

import numpy as np

from cnnsim import InputError
from cnnsim.program.file import load_program
from cnnsim.program.machine import UniversalMachine
from cnnsim.program.program import Program
from tactile.calibration.tare import Tare
from tactile.calibration.tare_check import TareCheck
from tactile.core.frame import Frame, TaxelArray
from tactile.events.code import CONTACT, SHEAR, encode
from tactile.events.comparators import Comparators
from tactile.events.detector import Observation
from tactile.events.event import Happening
from tactile.events.registry import detectors
from tactile.inverse.load import Load
from tactile.inverse.localise import localise
from tactile.settings import Settings
from tactile.texture.figures import Texture, TextureFigures


class Finger:
    """One array with its tare, its inverse, its comparators, its event detectors and its texture figures."""

    def __init__(self, array: TaxelArray, modulus: float | None, settings: Settings) -> None:
        contact = settings.contact or CONTACT[array.quantity]
        shear = settings.shear or SHEAR[array.quantity]
        machine = UniversalMachine(settings.backend, "float64")
        self.array = array = array if settings.depth is None else replace(array, depth=settings.depth)
        self._shear, self._contact = shear, contact
        self._tare, self._gains, self._radial = Tare(settings.tare), settings.gains, settings.radial
        self.tared: TareCheck | None = None  # what the tare took away, after the last of its frames
        self.taxels = Comparators(machine, array.shape, shear, contact)
        self._detectors = detectors(machine)
        self._texture = Texture(settings.window, contact.dead_band if settings.floor is None else settings.floor)
        self._machine, self._inverse = machine, _inverse(array, modulus, contact.dead_band)
        self._positions = array.positions()

    def calibrate(self, raw: Frame) -> Frame:
        """Return the frame less its tare, times the gains."""
        frame = self._tare(raw)
        self.tared = self._tare.check(self.array, self._gains)
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

    def notice(self, frame: Frame, load: Load | None) -> list[Happening]:
        """Run the comparators on the frame and return what the detectors say has happened."""
        changed = self.taxels.update(encode(frame, self.array.quantity, self._shear, self._contact))
        seen = Observation(frame, self.taxels.before, self.taxels.code, changed, load)
        return [what for detector in self._detectors for what in detector.detect(seen)]

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
