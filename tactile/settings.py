"""Settings of the pipeline, and how they follow from what a user chose: alike for files, ports and their recordings."""

from collections.abc import Iterable
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Self

from cnnsim.support import InputError
from tactile.calibration.gains import Gains
from tactile.calibration.live_tare import TareMode
from tactile.calibration.taxel_gains import TaxelGains
from tactile.core.frame import TaxelArray
from tactile.events.code import SIGN, Threshold
from tactile.events.thresholds import SIGMAS, Sigmas

if TYPE_CHECKING:  # SciPy's splines are slow to import
    from tactile.calibration.file import Calibration
    from tactile.calibration.radial import RadialCorrection


@dataclass(frozen=True)
class Settings:
    """What the pipeline can be told; None means: as the array's quantity asks for.

    ``shear`` and ``contact`` are the least thresholds in the unit of the signal, which ``sigmas`` times the noise of a
    taxel may pass; ``window`` T [frames] and ``floor`` (normal signal) of the texture figures; ``tare``: whether an
    offset is taken from still, unloaded frames by itself ("auto"), on request ("manual") or never ("off"); ``gains``
    from readings to the array's quantity, eq. (15); ``depth`` [m] to locate with and ``radial`` correction of what a
    taxel locates, as a scan measured them; ``programs``: users' detectors, files or names of the library; ``backend``
    of the machine.
    """

    shear: Threshold | None = None
    contact: Threshold | None = None
    sigmas: Sigmas = SIGMAS
    window: int = 128
    floor: float | None = None
    tare: TareMode = "off"
    gains: Gains | TaxelGains | None = None
    depth: float | None = None
    radial: "RadialCorrection | None" = None
    programs: tuple[str, ...] = ()
    backend: str = "cpu"

    def calibrated(self, skin: "Calibration | TaxelGains", arrays: Iterable[TaxelArray]) -> Self:
        """Return the settings with this skin's gains, depth and radial correction.

        Raises:
            InputError: an array that does not measure strain, or what the gains of taxels make, or of another shape.
        """
        if isinstance(skin, TaxelGains):
            shape = skin.matrix.shape[:2]
            for array in arrays:
                if array.quantity != skin.quantity or array.shape != shape:
                    raise InputError(
                        f"gains of {shape[0]} x {shape[1]} taxels of {skin.quantity} for taxel array {array.name!r}:"
                        f" {array.rows} x {array.cols} of {array.quantity}; those of this array wanted"
                    )
            return replace(self, gains=skin)
        for array in arrays:
            if array.quantity != "strain":
                raise InputError(f"a calibration for taxel array {array.name!r} of {array.quantity}; strain wanted")
        return replace(self, gains=skin.gains, depth=skin.depth, radial=skin.radial)


@dataclass(frozen=True)
class PipelineOptions:
    """The options of the command line that `run`, `replay` and `live` share.

    ``dead_band``, ``hysteresis`` and ``contact_level`` are least thresholds, a hysteresis of None half the dead band;
    ``sigmas`` as in `Sigmas`; ``program``: users' detectors and programs.
    """

    dead_band: float | None = None
    hysteresis: float | None = None
    contact_level: float | None = None
    sigmas: tuple[float, float, float] | None = None
    sign_code: bool = False
    window: int = 128
    floor: float | None = None
    program: tuple[str, ...] = ()
    backend: str = "cpu"
    tare: TareMode = "off"

    def settings(
        self, arrays: Iterable[TaxelArray], skin: "Calibration | TaxelGains | None", gains: Gains | None = None
    ) -> Settings:
        """Return the pipeline's settings for arrays with this skin's calibration, if there is one.

        Raises:
            InputError: thresholds that are none, or a calibration of strain for an array of something else.
        """
        shear = SIGN if self.sign_code else None
        if self.dead_band is not None:
            shear = Threshold(self.dead_band, self.dead_band / 2 if self.hysteresis is None else self.hysteresis)
        contact = None if self.contact_level is None else Threshold(self.contact_level, self.contact_level / 2)
        sigmas = SIGMAS if self.sigmas is None else Sigmas(*self.sigmas)
        chosen = Settings(
            shear, contact, sigmas, self.window, self.floor, self.tare, gains, programs=self.program,
            backend=self.backend,
        )  # fmt: skip
        return chosen if skin is None else chosen.calibrated(skin, arrays)
