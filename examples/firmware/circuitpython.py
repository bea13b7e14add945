"""Firmware of a tactile array in CircuitPython: reads all taxels at a set rate and sends them as native frames.

Fill in read_taxels and copy this file to the board as code.py; the rest is complete. Until then all taxels of a test
pattern are pressed for one second of four. For the second USB port that it sends on, boot.py has the two lines
import usb_cdc; usb_cdc.enable(data=True).
"""

# CircuitPython has no module typing:
# mypy: ignore-errors
import struct
import time

# begin of the configuration
RATE_HZ = 100
FORMAT = "h"  # counts, int16
FINGERS = (  # rows, columns, quantity per count of x, y, z, quantity of the test pattern
    # finger: the host computes strain = 1e-05 * shear count, 1e-05 * normal count
    (2, 2, (1e-05, 1e-05, 1e-05), (0.0, 0.0, 0.01)),
    # palm: the host computes strain = 1e-05 * shear count, 1e-05 * normal count
    (8, 8, (1e-05, 1e-05, 1e-05), (0.0, 0.0, 0.01)),
)
# end of the configuration


def read_taxels(finger, seconds):
    """FILL IN: return x, y, z of every taxel of the array `finger`, row by row, as a list of numbers."""
    rows, cols, gains, touch = FINGERS[finger]
    taxel = [part / gain if seconds % 4 >= 3 else 0 for part, gain in zip(touch, gains)]  # noqa: B905 - the board's zip has no strict
    return [int(value) if FORMAT == "h" else value for value in taxel] * (rows * cols)


def _table():
    """Return the CRC of every byte: polynomial 0x1021."""
    table = []
    for byte in range(256):
        crc = byte << 8
        for _ in range(8):
            crc = (crc << 1) ^ 0x1021 if crc & 0x8000 else crc << 1
        table.append(crc & 0xFFFF)
    return table


TABLE = _table()


def cobs(packet):
    """Return the COBS code of a packet, with the zero byte that ends a frame."""
    out, code = bytearray(1), 0
    for byte in packet:
        if len(out) - code == 255:
            out[code], code = 255, len(out)
            out.append(0)
        if byte:
            out.append(byte)
        else:
            out[code], code = len(out) - code, len(out)
            out.append(0)
    out[code] = len(out) - code
    out.append(0)
    return out


def encode(finger, sequence, micros, values):
    """Return the native frame of one array: x, y, z of every taxel, row by row, read at `micros` [us]."""
    rows, cols, _, _ = FINGERS[finger]
    packet = struct.pack("<BBBBBIQ", 1, finger, rows, cols, FORMAT == "f", sequence & 0xFFFFFFFF, micros)
    packet += struct.pack("<" + str(len(values)) + FORMAT, *values)
    crc = 0xFFFF
    for byte in packet:
        crc = ((crc << 8) & 0xFFFF) ^ TABLE[crc >> 8 ^ byte]
    return cobs(packet + struct.pack("<H", crc))


def main():
    """Send a frame of every array in each period; missed periods count as lost frames on the host."""
    import usb_cdc  # only on boards

    port, period = usb_cdc.data or usb_cdc.console, 1_000_000_000 // RATE_HZ
    start = time.monotonic_ns()
    sequence = 0
    port.write(b"\0")  # ends any noise before the first frame
    while True:
        now = time.monotonic_ns() - start
        if now // period == sequence:
            continue
        sequence = now // period
        for finger in range(len(FINGERS)):
            values = read_taxels(finger, now / 1e9)
            port.write(encode(finger, sequence, now // 1000, values))


if __name__ == "__main__":
    main()
