"""Registry of wire formats. A new one is one file in ``formats`` with its ``FORMATS``, and its name here."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from cnnsim.support import InputError
from cnnsim.support.extras import need
from tactile.wire.base import Decoder, Encoder, Options, Talk

NAMES = {
    "reskin": "reskin",
    "papillarray": "papillarray.decoder",
    "paxini-fast": "paxini.decoder",
    "paxini-serial": "paxini.decoder",
    "lowiek": "lowiek",
    "native": "native",
    "csv": "csv_text",
}
"""Protocol name -> module of `tactile.wire.formats` with its ``FORMATS`` entry."""


@dataclass(frozen=True)
class Format:
    """A wire format: default ``baudrate``, and ``keys`` of its own options.

    ``strong``: reading of a firm touch, for emulators of uncalibrated devices, None if the device sends the quantity
    itself; ``pushes``: z is positive when pressed and cannot be negative; ``calibrated``: readings are the quantity;
    ``single``: it has one array; ``blanks``: a reading may be NaN; ``normal_alone``: a taxel may have z only;
    ``fingers``: their tables if the device has only one form.
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
    normal_alone: bool = False
    fingers: tuple[dict[str, Any], ...] = ()


def find_format(name: str) -> Format:
    """Return the format of that name.

    Raises:
        InputError: an unknown name, or a missing library.
    """
    if name not in NAMES:
        raise InputError(f"protocol {name!r}; one of {', '.join(NAMES)} wanted")
    found: Format = need(f"tactile.wire.formats.{NAMES[name]}", f"protocol {name!r}").FORMATS[name]
    return found  # imported only when used
