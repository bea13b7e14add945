"""Options of a live run: kept by its recording, and used again when that is run or replayed."""

import json
from dataclasses import asdict, dataclass, fields
from typing import TYPE_CHECKING, Final, Literal

from cnnsim import backends
from cnnsim.support import InputError
from cnnsim.support.toml_file import check_keys, take
from tactile.settings import PipelineOptions

if TYPE_CHECKING:
    from tactile.calibration.file import Calibration
    from tactile.calibration.taxel_gains import TaxelGains

AUTO: Final = "auto"
MANUAL, OFF = "manual", "off"


@dataclass(frozen=True)
class LiveOptions(PipelineOptions):
    """Options of a live run; a recording keeps them, so that a replay is identical.

    ``calibration`` is the text of a calibration file. Tare and gains of the description come before the pipeline.
    """

    tare: Literal["auto", "manual", "off"] = AUTO
    calibration: str | None = None

    @property
    def skin(self) -> "Calibration | TaxelGains | None":
        """The calibration in the text.

        Raises:
            InputError: it is invalid.
        """
        if self.calibration is None:
            return None
        from tactile.calibration.file import parse_calibration  # slow to import

        return parse_calibration(self.calibration, "calibration")

    def text(self) -> str:
        """Return all as JSON."""
        return json.dumps(asdict(self))


def recorded_options(text: str, where: str) -> LiveOptions:
    """Return the options that a recording keeps as JSON.

    Raises:
        InputError: invalid JSON, an unknown option, or a value of another kind.
    """
    kinds = {
        "window": int,
        "sign_code": bool,
        "dead_band": float,
        "hysteresis": float,
        "floor": float,
        "contact_level": float,
        "program": list,
        "sigmas": list,
    }
    lead = f"{where}: choices of the live run"
    try:
        found = json.loads(text)
    except ValueError as error:
        raise InputError(f"{lead}: damaged: {error}") from error
    check_keys(found, [field.name for field in fields(LiveOptions)], lead)
    for name, value in found.items():
        optional = LiveOptions.__dataclass_fields__[name].default is None
        if not (optional and value is None):
            take(found, name, kinds.get(name, str), lead)
    for name, known in (("tare", (AUTO, MANUAL, OFF)), ("backend", backends.NAMES)):
        if found.get(name) not in (None, *known):
            raise InputError(f"{lead}: {name} = {found[name]!r}; one of {', '.join(known)} wanted")
    for name in ("program", "sigmas"):  # JSON has no tuples
        if found.get(name) is not None:
            found[name] = tuple(found[name])
    return LiveOptions(**found)
