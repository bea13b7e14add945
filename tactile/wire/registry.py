"""Names of the wire formats. A new one is one file in ``formats`` with its ``FORMATS``, and its name here."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from cnnsim.support import InputError
from tactile.wire.base import Decoder, Encoder, Options, Talk
from tactile.wire.extras import need

NAMES = {
    "reskin": "reskin",
    "papillarray": "papillarray.decoder",
    "paxini-fast": "paxini.decoder",
    "paxini-serial": "paxini.decoder",
    "lowiek": "lowiek",
    "native": "native",
    "csv": "csv_text",
}
"""Protocol name -> the module of `tactile.wire.formats` that has it in ``FORMATS``."""


@dataclass(frozen=True)
class Format:
    """A wire format: ``baudrate`` where the user gives none, ``keys`` its own options.

    ``strong`` is a reading that a firm touch may give, for emulators of devices that nobody has calibrated, None where
    firmware sends the quantity itself; ``pushes``: z is positive when pressed and cannot be negative; ``calibrated``:
    the readings are the quantity as they come; ``single``: it carries one array; ``blanks``: a reading may be NaN;
    ``fingers``: their tables where the device has only one form.
    """

    name: str
    summary: str
    baudrate: int
    strong: float | None
    decoder: Callable[[Options], Decoder]
    encoder: Callable[[Options], Encoder]
    talk: Callable[[Options], Talk] = lambda options: Talk()
    keys: tuple[str, ...] = ()
    pushes: bool = False
    calibrated: Callable[[Options], bool] = lambda options: True
    single: bool = False
    blanks: bool = False
    fingers: tuple[dict[str, Any], ...] = ()


def find_format(name: str) -> Format:
    """Return the format of that name.

    Raises:
        InputError: there is none, or a library that it wants is missing.
    """
    if name not in NAMES:
        raise InputError(f"protocol {name!r}; one of {', '.join(NAMES)} wanted")
    found: Format = need(f"tactile.wire.formats.{NAMES[name]}", f"protocol {name!r}").FORMATS[name]
    return found  # only the one that is used is imported
