"""Opening a scene or recording with the settings of the user, of its live run, or of its file."""

from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING

from cnnsim.support import InputError
from tactile.calibration.gains import Gains
from tactile.calibration.live_tare import TareMode
from tactile.core.frame import TaxelArray
from tactile.core.source import Source, provenance
from tactile.settings import PipelineOptions, Settings
from tactile.sources import open_source

if TYPE_CHECKING:
    from tactile.layout.layout import Layout
    from tactile.live_options import LiveOptions
    from tactile.simulator.bump_cover import Bumps


@dataclass(frozen=True)
class RunChoices:
    """Choices of a user of `tactile run`: ``options``, mode of ``tare``, ``gains`` or a ``calibration`` file.

    ``layout``: that of tables of other programs.
    """

    options: PipelineOptions
    tare: TareMode | None = None
    gains: Gains | None = None
    calibration: Path | None = None
    layout: "Layout | Path | None" = None


@dataclass(frozen=True)
class Opened:
    """A ``source``, its ``settings`` and tare ``mode``; ``notes`` on it and on its ``forces``."""

    source: Source
    settings: Settings
    mode: TareMode
    notes: tuple[str, ...]
    forces: str


def open_for_run(path: Path, choices: RunChoices) -> Opened:
    """Open a scene or a recording.

    Raises:
        InputError: it cannot be opened, its readings have no unit, or the choices do not fit it.
    """
    return for_run(open_source(path, choices.layout), choices, str(path))


def for_run(source: Source, choices: RunChoices, name: str) -> Opened:
    """Return a source with its settings; ``name`` is that of its file in messages.

    Raises:
        InputError: its readings have no unit, or the choices do not fit it.
    """
    known = provenance(source)
    if known.uncalibrated and choices.calibration is None and choices.gains is None:
        raise InputError(
            f"{name}: finger {known.uncalibrated[0]!r}: readings in the unit of the wire, which is no quantity;"
            " --gains SHEAR,NORMAL or --calibration FILE wanted"
        )
    lived = _recorded(known.choices, name)
    mode = choices.tare if choices.tare is not None else lived.tare if lived else ("auto" if known.untared else "off")
    skin = lived.skin if lived else None
    if choices.calibration is not None:
        from tactile.calibration.file import load_calibration  # slow to import

        skin = load_calibration(choices.calibration)
    options = lived.but(choices.options) if lived else choices.options
    settings = replace(options, tare=mode).settings(source, skin, choices.gains)
    notes = (*getattr(source, "range_notes", ()), *getattr(source, "notes", ()))  # of scenes, of readers
    bumps, forces = getattr(source, "bumps", None), ""  # scenes may have them
    if bumps is not None and choices.calibration is None:
        settings, forces = _on_bumps(settings, source.arrays, bumps)
    return Opened(source, settings, mode, notes, forces)


def _recorded(choices: str, name: str) -> "LiveOptions | None":
    """Return the options of the live run that recorded a source, None for other sources."""
    if not choices:
        return None
    from tactile.live_options import recorded_options  # imported when used

    return recorded_options(choices, name)


def _on_bumps(settings: Settings, arrays: tuple[TaxelArray, ...], bumps: "Bumps") -> tuple[Settings, str]:
    """Return settings that scale the forces of a flat cover's inverse to those on a bump, and a note."""
    from tactile.calibration.radial import RadialCorrection  # slow to import

    factors = {array.name: bumps.over_flat(array, array.quantity) for array in arrays}
    factor = max(factors.values())
    if min(factors.values()) < factor * (1 - 1e-9):
        each = ", ".join(f"{name} {one:.3g}" for name, one in factors.items())
        return settings, f"forces are a flat cover's; times so much they are right for a load on one bump: {each}"
    said = f"forces are {factor:.3g} times a flat cover's: right for a load on one bump, not between bumps"
    return replace(settings, radial=RadialCorrection.constant(factor)), said
