"""Serial ports: list, open and read them, with error messages that name a cure."""

import contextlib
import errno
from typing import TYPE_CHECKING

from cnnsim.support import InputError
from cnnsim.support.extras import need

if TYPE_CHECKING:
    import serial

GONE = "the device behind it is gone: plug it in again"
CURES = {
    errno.ENOENT: "there is no such port: is the device plugged in? `tactile ports` lists the ports there are",
    errno.ENODEV: GONE,
    errno.ENXIO: GONE,
    errno.EIO: GONE,
    errno.EACCES: "no permission: add yourself to the group that owns it (often `sudo usermod -aG dialout $USER`,"
    " then log in again)",
    errno.EPERM: "no permission: another program may have it for itself, or the group `dialout` is wanted",
    errno.EBUSY: "busy: another program has it open (`fuser -v` on the port names it); close that first",
    errno.EAGAIN: "busy: another reader has it open (`fuser -v` on the port names it); close that first",
    errno.ENOTTY: "not a serial port",
    errno.EISDIR: "not a serial port",
}
"""Error number -> meaning and cure."""
KNOWN = {
    (0x16D0, 0x14CC): "Robotiq TSF-85",
    (0x04B4, 0xF232): "Robotiq TSF-85",
    (0x2341, None): "Arduino board",
    (0x239A, None): "Adafruit board (used by ReSkin and AnySkin)",
    (0x2E8A, None): "Raspberry Pi Pico",
    (0x303A, None): "Espressif board",
    (0x16C0, 0x0483): "Teensy",
    (0x0403, None): "FTDI adapter",
    (0x10C4, None): "Silicon Labs adapter",
    (0x1A86, None): "WCH adapter",
}
"""USB vendor and product (None for any) -> likely device."""


def open_port(name: str, baudrate: int) -> "serial.Serial":
    """Open a port exclusively, 8N1, without flow control.

    Raises:
        InputError: it cannot be opened; the message has the reason and a cure.
    """
    serial = need("serial", "a serial port")
    try:
        port = serial.Serial(name, baudrate, timeout=0.05, write_timeout=1.0, exclusive=True)
    except (OSError, ValueError) as error:  # SerialException is an OSError
        number = error.errno if isinstance(error, OSError) else None
        what = CURES.get(number, str(error)) if number is not None else _configured(str(error))
        raise InputError(f"port {name}: {what}") from error
    with contextlib.suppress(OSError, ValueError, NotImplementedError):  # not all drivers have it
        port.set_low_latency_mode(True)  # USB adapters wait 16 ms for more bytes otherwise
    return port


def _configured(text: str) -> str:
    """Return the cure where pyserial hides the error number in its text."""
    for number in (errno.ENOTTY, errno.EIO):
        if f"({number}," in text:
            return CURES[number]
    return text


def list_ports() -> list[dict[str, str]]:
    """Return every port's ``port``, ``what`` and ``hint``, those on USB first."""
    found = need("serial.tools.list_ports", "a serial port").comports()
    rows = []
    for port in sorted(found, key=lambda port: (port.vid is None, port.device)):
        hint = KNOWN.get((port.vid, port.pid), KNOWN.get((port.vid, None), ""))
        usb = "" if port.vid is None else f" {port.vid:04x}:{port.pid:04x}"
        rows.append({"port": port.device, "what": f"{port.description}{usb}", "hint": hint})
    return rows
