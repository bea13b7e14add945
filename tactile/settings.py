"""Settings of the pipeline, and how they follow from options, array files and recordings."""

from collections.abc import Iterable
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Self

from cnnsim.support import InputError
from cnnsim.support.errors import shown
from cnnsim.support.keywords import spelled_class
from cnnsim.support.values import is_number, is_whole
from tactile.calibration.gains import Gains
from tactile.calibration.live_tare import TareMode
from tactile.calibration.taxel_gains import TaxelGains
from tactile.core.frame import TaxelArray
from tactile.core.source import Source, provenance
from tactile.thresholds.choices import ThresholdChoices
from tactile.thresholds.levels import SIGMAS, Sigmas
from tactile.thresholds.threshold import Threshold

if TYPE_CHECKING:  # SciPy's splines are slow to import
    from tactile.calibration.file import Calibration
    from tactile.calibration.radial import RadialCorrection


TARES = ("auto", "manual", "off")


@spelled_class
@dataclass(frozen=True)
class Settings:
    """Settings of the pipeline; None selects the default of the array's quantity.

    ``shear`` and ``contact``: lower limits of the thresholds [unit of the signal]; ``sigmas``: thresholds as multiples
    of the noise; ``window`` T [frames] and ``floor`` (normal signal) of the texture figures; ``tare``: offsets are
    taken from still, unloaded frames ("auto"), on request ("manual"), never ("off"), or from a number of frames; None:
    "auto" for readings of a device with their offsets, else "off";
    ``gains`` from readings to the array's quantity, eq. (15); ``depth`` [m] and ``radial`` correction for locating
    loads, from a calibration scan; ``programs``: users' detectors, files or names of the library; ``backend`` of the
    machine.

    Raises:
        InputError: a value of another kind, or an unknown tare mode.
    """

    shear: Threshold | None = None
    contact: Threshold | None = None
    sigmas: Sigmas = SIGMAS
    window: int = 128
    floor: float | None = None
    tare: TareMode | None = None
    gains: Gains | TaxelGains | None = None
    depth: float | None = None
    radial: "RadialCorrection | None" = None
    programs: tuple[str, ...] = ()
    backend: str = "cpu"

    def __post_init__(self) -> None:
        for name in ("shear", "contact"):
            if not isinstance(getattr(self, name), Threshold | None):
                raise InputError(
                    f"{name} {getattr(self, name)!r}; a Threshold wanted, such as Threshold(dead_band, hysteresis)"
                )
        if not isinstance(self.sigmas, Sigmas):
            raise InputError(f"sigmas {self.sigmas!r}; Sigmas wanted, such as {SIGMAS!r}")
        if not is_whole(self.window):
            raise InputError(f"window {self.window!r}; a whole number of frames wanted")
        for name in ("floor", "depth"):
            if getattr(self, name) is not None and not is_number(getattr(self, name)):
                raise InputError(f"{name} {getattr(self, name)!r}; a number wanted")
        if not isinstance(self.gains, Gains | TaxelGains | None):
            raise InputError(f"gains {self.gains!r}; Gains wanted, such as Gains(shear, normal)")
        if self.tare is not None and self.tare not in TARES and not is_whole(self.tare):
            raise InputError(f"tare {self.tare!r}; one of {', '.join(map(repr, TARES))} or a number of frames wanted")
        if isinstance(self.programs, str | Path) or not isinstance(self.programs, Iterable):
            raise InputError(f"programs {shown(self.programs)}; a tuple of files or names wanted")

    def of(self, source: Source) -> Self:
        """Return the settings of a run: tare of the ``source``, and thresholds of its array file if none is chosen.

        Raises:
            InputError: the array file in a recording is invalid.
        """
        tare = self.tare
        if tare is None:
            tare = "auto" if provenance(source).untared else "off"
        shear, contact, sigmas = self.shear, self.contact, self.sigmas
        if (shear, contact, sigmas) == (None, None, SIGMAS):
            shear, contact, sigmas = described(source).thresholds()
        return replace(self, tare=tare, shear=shear, contact=contact, sigmas=sigmas)

    def calibrated(self, skin: "Calibration | TaxelGains", arrays: Iterable[TaxelArray]) -> Self:
        """Return the settings with the gains, depth and radial correction of a skin.

        Raises:
            InputError: an array of another quantity or shape than that of the calibration.
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


DEFAULT = Settings()
"""Default settings."""


@dataclass(frozen=True)
class PipelineOptions(ThresholdChoices):
    """Command-line options that `run`, `replay` and `live` share; None is no choice.

    ``window`` and ``floor`` as in `Settings`; ``program``: users' detectors and programs.
    """

    window: int | None = None
    floor: float | None = None
    program: tuple[str, ...] = ()
    backend: str | None = None
    tare: TareMode = "off"

    def but(self, chosen: ThresholdChoices) -> Self:
        """Return these options, each replaced by that of ``chosen`` where it has one, except the tare."""
        changed = super().but(chosen)
        if isinstance(chosen, PipelineOptions):
            given = {name: getattr(chosen, name) for name in ("window", "floor", "backend")}
            changed = replace(changed, **{name: one for name, one in given.items() if one is not None})
            changed = replace(changed, program=chosen.program or self.program)
        return changed

    def settings(
        self, source: Source, skin: "Calibration | TaxelGains | None" = None, gains: Gains | None = None
    ) -> Settings:
        """Return the pipeline settings for a source; thresholds not chosen come from its array description.

        Arguments: ``skin``: calibration of its arrays; ``gains`` from readings to their quantity.

        Raises:
            InputError: invalid thresholds, or a calibration for another quantity.
        """
        shear, contact, sigmas = described(source).but(self).thresholds()
        chosen = Settings(
            shear,
            contact,
            sigmas,
            DEFAULT.window if self.window is None else self.window,
            self.floor,
            self.tare,
            gains,
            programs=self.program,
            backend=DEFAULT.backend if self.backend is None else self.backend,
        )
        return chosen if skin is None else chosen.calibrated(skin, source.arrays)


def described(source: Source) -> ThresholdChoices:
    """Return the thresholds in the array description of a source, if it has one.

    Raises:
        InputError: the description is invalid.
    """
    text = provenance(source).description
    if not text:
        return ThresholdChoices()
    from tactile.wire.description_file import parse_description  # imported for device recordings only

    return parse_description(text, "array description").thresholds
