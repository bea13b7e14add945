"""Finger: the state of one taxel array between frames, and the pipeline stages of a frame."""

from collections.abc import Mapping
from dataclasses import replace
from typing import Any

import numpy as np

from cnnsim.program.machine import UniversalMachine
from cnnsim.support import Flags, Floats
from tactile.calibration.live_tare import LiveTare, TareMode
from tactile.calibration.tare_check import TareNote, end_note, gap_note
from tactile.core.frame import Frame, TaxelArray
from tactile.core.frozen import Frozen
from tactile.core.gaps import Gaps
from tactile.core.noise import Noise
from tactile.core.saturation import Saturation
from tactile.events.code import Code, encode
from tactile.events.comparators import BINARY, Comparators
from tactile.events.detector import Detector, Transition
from tactile.events.detector_file import SHIPPED, shipped_detectors, users_detectors
from tactile.events.hidden_contact import HiddenContact
from tactile.events.load_travel import Travel
from tactile.events.planes import CODE, Moment, PlanePool
from tactile.events.signals.signals import Signals
from tactile.inverse.load import Load
from tactile.inverse.localise import NO_LOAD, FrameFit, localise
from tactile.inverse.summed import summed
from tactile.inverse.weights import fit_floor, inverse_program, newtons, weigh
from tactile.settings import Settings
from tactile.texture.figures import Texture, TextureFigures
from tactile.thresholds.levels import levels
from tactile.thresholds.threshold import CONTACT, SIGN

STILL, APART = 0.6, 0.1
"""[s] Time without a sign of sliding after which nothing slides; longest loss of contact between the asperities of a
rough material, whose frames are ignored."""
LIVELY = 0.25
"""Unsteadiness of the normal load on a moving texture: 1 % of the load, above its noise; a grip has a tenth of it."""


class Finger:
    """One array with its tare, inverse, comparators, detectors and texture figures."""

    def __init__(self, array: TaxelArray, modulus: float | None, settings: Settings, number: int = 0) -> None:
        self.array = array if settings.depth is None else replace(array, depth=settings.depth, thickness=None)
        self._settings, self._gains, self._radial = settings, settings.gains, settings.radial
        self._modulus, self._number, self._gaps = modulus, number, Gaps()
        self.broken: float | None = None
        self._mode: TareMode = "off" if settings.tare is None else settings.tare
        self.tare = LiveTare(number, self.array, self._mode, settings.gains)
        self._start()

    def _start(self) -> None:
        """Set the state before the first frame, and after a break of the stream, except that of the tare."""
        array, modulus, settings = self.array, self._modulus, self._settings
        contact = settings.contact or CONTACT[array.quantity]
        machine = UniversalMachine(settings.backend, "float64")
        self._signs = settings.shear == SIGN
        self.taxels = Comparators(machine, array.shape, SIGN if self._signs else BINARY, BINARY)
        self._signals, self._pool = Signals(array.shape, array.quantity), PlanePool(machine, array.shape)
        # one machine each, so that programs of the same name do not share memory
        self._detectors = [
            Detector(file, UniversalMachine(settings.backend, "float64"), self._pool, publishes=n < len(SHIPPED))
            for n, file in enumerate([*shipped_detectors(SHIPPED), *users_detectors(settings.programs)])
        ]
        self._own = self._detectors[len(SHIPPED) :]
        self._travel, self._whole = Travel(), Signals((1, 1), "force")
        least = (contact if array.quantity == "force" else CONTACT["force"]).dead_band
        self._figures = Texture(settings.window, least if settings.floor is None else settings.floor)
        self._last_figures: TextureFigures | None = None
        self._dead_band, floor = contact.dead_band, fit_floor(array, contact.dead_band)
        self._machine, self._inverse = machine, inverse_program(array, modulus, floor)
        if self._inverse is not None:
            machine.prepare(self._inverse, array.shape)
        alone = self._inverse is not None and machine.backend.name == "cpu" and self._radial is None
        self._point = FrameFit(array, modulus, floor) if alone else None
        self._positions, self._newtons = array.positions(), newtons(array, modulus)
        self._half = array.cols * array.pitch / 2, array.rows * array.pitch / 2
        self._hidden = None if self._inverse is None else HiddenContact(array, self._newtons)
        self._rails, self._still = Saturation(array.shape), Frozen(array.shape)
        self._saturated: Flags | None = None
        self._nothing = np.full((1, 1, 3) if self._inverse is not None else (*array.shape, 3), np.nan)
        self._noise: Noise | None = None
        self._early: Floats | None = None
        self._offset: Floats | None = None
        self._per_sigma: Floats | None = None
        self._slid = self._pressed = -np.inf
        self._travels, self._all_used = False, True
        self._set_noise()

    def calibrate(self, raw: Frame) -> Frame:
        """Return the frame after tare and gains; ``broken`` is the time [s] at which all events end, else None.

        It is that of the frame before a gap in the times, after which all begins anew, or of a zero that moved.
        """
        self.broken = last = self._gaps(raw.t)
        if last is not None:
            self.tare = LiveTare(self._number, self.array, self._mode, self._gains)
            self.tare.notes.append(gap_note(self._number, last, raw.t))
            self._start()
        frame = self.tare(raw)
        if self.tare.moved is not None:
            self.broken, self.tare.moved = self.tare.moved, None
            self._start()
        if self.tare.noise is not self._noise or (self._noise is None and self.tare.early is not self._early):
            self._set_noise()
        for note in self.tare.notes:
            if note.offset is not None:
                taken = note.offset - (note.offset if self._offset is None else self._offset)
                self._offset = note.offset
                self._signals.forget_drift(taken if self._gains is None else self._gains(taken))
        if self._noise is not None:
            self._saturated = self._rails(raw.values, self._noise.jitter)
            if self._saturated is not None and (words := self._rails.words(raw.values)):
                self.tare.notes.append(end_note(self._number, raw.t, words))
        return frame if self._gains is None else replace(frame, values=self._gains(frame.values))

    def _set_noise(self) -> None:
        self._noise = noise = self.tare.noise
        if noise is not None and self._gains is not None:
            sigma, jitter, typical = (self._gains.spread(one) for one in (noise.sigma, noise.jitter, noise.typical))
            noise = replace(noise, sigma=sigma, jitter=jitter, typical=typical)
        self._early = early = self.tare.early
        if early is not None and self._gains is not None:
            early = self._gains.spread(early)
        shear = None if self._signs else self._settings.shear
        array, chosen = self.array, self._settings
        self.levels = levels(array.shape, array.quantity, chosen.sigmas, shear, chosen.contact, noise, early)
        self._signals.set_noise(noise, self.levels)
        self._left_out: Flags = np.zeros(array.shape, bool) if noise is None else noise.left_out
        self._leaves_out = bool(self._left_out.any())
        self._floor = float(np.median(self.levels.off[..., 2]))
        if self._hidden is not None:
            self._hidden.set_levels(self.levels)
        levels_of = None if noise is None else noise.levels
        known = None if levels_of is None or self._inverse is None else levels_of * self._newtons
        known = known if known is not None and (known > 0).all() else None
        self._weights = weigh(known, array.shape)
        self._per_sigma = None
        if known is not None and not self._left_out.all():
            self._per_sigma = np.where(self._left_out[..., None], 0, self._newtons / known)

    def locate(self, frame: Frame) -> Load:
        """Return the load under this finger: the inverse of every cell and their consensus, or their sum."""
        from tactile.core.noise_numba import is_noise, is_within  # numba is slow to import

        if self._inverse is None:
            return summed(self._positions, frame.values, frame.valid, self._floor)
        values = frame.values
        if not frame.whole or self._leaves_out:
            values = np.where((frame.valid & ~self._left_out)[..., None], values, np.nan)
        noise = self._per_sigma if frame.whole and self._saturated is None else None
        if is_within(values, self._dead_band) or (noise is not None and is_noise(frame.values, noise)):
            return NO_LOAD
        if self._point and self._saturated is None and (load := self._point(values, self._weights)) is not None:
            return load
        signals = {name: values[..., i] for i, name in enumerate(self._inverse.inputs)}
        planes = tuple(self._machine.run(self._inverse, **signals).values())
        if self._radial is not None:
            planes = self._radial.of_signs(planes)
        pressing, pulling = planes[:4], planes[4:] or None
        known = self._weights, self._saturated, self.array.thickness
        return localise(self._positions, pressing, pulling, self.array.depth, *known)

    def detect(self, frame: Frame, load: Load) -> list[Transition]:
        """Run the comparators and detectors on the frame and return the events that begin and end."""
        if not frame.whole and not frame.valid.any():
            return []  # no offset yet, or no valid taxel: lasting events continue
        left_out = self._still(frame.values, self.taxels.code.contact, self._left_out)
        self._signals.leave_out(left_out)
        if left_out is not self._left_out and (words := self._still.words()):
            self.tare.notes.append(TareNote(self._number, frame.t, words, None, "until it changes", notice=True))
        all_used = frame.whole and not (self._leaves_out if left_out is self._left_out else left_out.any())
        use = frame.valid if all_used else frame.valid & ~left_out
        before = self._signals.planes.copy() if self._own else self._signals.planes
        contact = self._pool.black("in_contact")
        self._signals.update(frame, use, self.levels, contact)
        if self._inverse is not None:
            self._whole.take_load(frame.t, load, contact)
            self._signals.put_load(self._whole)
        planes = self._signals.planes
        if self._hidden is not None:
            self._hidden.write(load, planes[2], use)
        array, pool = self.array, self._pool
        if self._signs:
            signs = encode(frame, array.quantity, SIGN, BINARY)
            changed = self.taxels.update(np.array([signs["shear_x"], signs["shear_y"], planes[2]]))
        else:
            changed = self.taxels.update(planes)
        if changed:
            code = self.taxels.code
            for name, on in zip(CODE, (code.x > 0, code.x < 0, code.y > 0, code.y < 0, code.contact), strict=True):
                pool.set_logic(name, on)
        if not (all_used and self._all_used):
            self._all_used = all_used
            pool.set_logic("usable", use)
        pool.update(Moment(frame, array.quantity, self._signals, before, load, self._half, array.origin))
        if self._inverse is not None:
            travels = self._travel.update(frame.t, load, self.taxels.code.pressed > 0)
            if travels != self._travels:
                self._travels = travels
                pool.set_logic("travelling", travels)
        found = [what for detector in self._detectors for what in detector.update(frame.t)]
        if pool.black("in_contact"):
            self.tare.touched(frame.t)
        return found

    def texture(self, frame: Frame, load: Load) -> TextureFigures:
        """Return the texture figures after this frame: of every taxel that measures force, else of the located load.

        A frame counts only while something slides: a slip or a change of the tangential load within `STILL`, or a
        normal load as unsteady as on a texture. Frames in which a located load is lost for less than `APART` are left
        out of the window.
        """
        pool, whole = self._pool, self._signals if self._inverse is None else self._whole
        lively = whole.unrest > LIVELY and not (pool.black("rising") or pool.black("dropping"))
        if pool.black("slides") or pool.black("driven") or lively:
            self._slid = frame.t
        if frame.t - self._slid > STILL or not self.array.shear:
            values = self._nothing
        elif self._inverse is not None:
            if self._figures.floor < load.F:
                self._pressed = frame.t
            elif self._last_figures is not None and 0 <= frame.t - self._pressed < APART:
                return self._last_figures
            values = np.array([[[load.Q, load.R, load.F]]])
        else:
            values = frame.values if frame.whole else np.where(frame.valid[..., None], frame.values, np.nan)
        self._last_figures = self._figures.update(values)
        return self._last_figures

    @property
    def code(self) -> Code:
        """Current code of the comparators."""
        return self.taxels.code

    @property
    def travelled(self) -> tuple[float, float] | None:
        """Distance of the located load during its last slip [m]; None where loads are not located."""
        return None if self._inverse is None else self._travel.way

    def tare_notes(self) -> tuple[TareNote, ...]:
        """Return the changes of the tare since the last call."""
        notes, self.tare.notes = tuple(self.tare.notes), []
        return notes

    def program_outputs(self) -> Mapping[str, Mapping[str, Any]]:
        """Return the outputs of users' programs that changed with this frame."""
        return {one.file.name: one.outputs for one in self._own if one.changed}
