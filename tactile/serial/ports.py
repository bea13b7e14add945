"""List of serial ports with a guess of the device."""

from tactile.wire.extras import need

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


def list_ports() -> list[dict[str, str]]:
    """Return every port's ``port``, ``what`` and ``hint``, those on USB first."""
    found = need("serial.tools.list_ports", "a serial port").comports()
    rows = []
    for port in sorted(found, key=lambda port: (port.vid is None, port.device)):
        hint = KNOWN.get((port.vid, port.pid), KNOWN.get((port.vid, None), ""))
        usb = "" if port.vid is None else f" {port.vid:04x}:{port.pid:04x}"
        rows.append({"port": port.device, "what": f"{port.description}{usb}", "hint": hint})
    return rows
