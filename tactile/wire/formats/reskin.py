"""ReSkin and AnySkin boards: magnetometer chips as bare floats that end in CR LF.

One frame, little endian: for every chip (5 unless the description says otherwise) float32 temperature [deg C], x, y, z
[uT]; then 0D 0A. No header, checksum, sequence number or time, and CR LF may occur inside a float.

In step, CR LF has to stand where the frame ends, with no number that a chip cannot send: a temperature of -40..150
deg C, fields of 100 mT at most. Out of step every offset is tried; there a field is 0 or 0.1 nT at least, and a chip is
alive or sends only zeros. Bytes at random pass that once in about 10^20 frames; a number that is changed to another
within those bounds goes unseen.

Sources: reskin_sensor 2.0.2 ``sensor.py``; anyskin ``5X_binary_burst_stream.ino``.
"""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from tactile.wire.base import Decoder, Encoder, Found, Options
from tactile.wire.reading import Reading, Taxels
from tactile.wire.registry import Format

END = b"\r\n"
TEMPERATURE = (-40.0, 150.0)
"""Coldest and hottest chip [deg C]."""
FIELD = (1e-4, 1e5)
"""Smallest field that is not 0, and the largest [uT]."""
LOWEST = np.array([TEMPERATURE[0], *[-FIELD[1]] * 3], np.float32)
HIGHEST = np.array([TEMPERATURE[1], *[FIELD[1]] * 3], np.float32)
ROOM_TEMPERATURE = 25.0


def possible(chips: NDArray[np.float32]) -> bool:
    """Return whether all numbers (chips, 4) are within the range of the chips."""
    return bool(((chips > LOWEST) & (chips < HIGHEST)).all())


def plausible(chips: NDArray[np.float32]) -> bool:
    """Return whether numbers (chips, 4) are plausible readings of chips: see the docstring of this module."""
    size = np.abs(chips)
    field = ((size[:, 1:] >= FIELD[0]) & (size[:, 1:] <= FIELD[1])) | (size[:, 1:] == 0)
    alive = (chips[:, 0] > TEMPERATURE[0]) & (chips[:, 0] < TEMPERATURE[1]) & (size[:, 0] > 1e-3)
    dead = (size == 0).all(1)
    return bool(alive.any() and ((alive & field.all(1)) | dead).all())


class ReskinDecoder(Decoder):
    """Decodes frames of as many chips as the boards have taxels; the chips of all boards follow each other."""

    def __init__(self, options: Options) -> None:
        super().__init__()
        self._chips = sum(options.taxels)
        self._length = 16 * self._chips + len(END)
        self._in_step = False

    def _restart(self) -> None:
        self._in_step = False

    def _next(self, over: bool) -> Found | None:
        length, data = self._length, self._buffer
        if len(data) < length:
            return None
        if self._in_step and data[length - 2 : length] == END and possible(self._numbers(0)):
            return self._found(0)
        self._in_step = False
        at = -1
        while (mark := data.find(END, at + length - 1)) >= 0:
            at = mark + len(END) - length
            if plausible(self._numbers(at)):
                self._in_step = True
                return self._found(at)
        # no frame ends in this buffer, so none begins before its last length - 1 bytes
        return Found(len(data) - length + 1)

    def _numbers(self, at: int) -> NDArray[np.float32]:
        return np.frombuffer(bytes(self._buffer[at : at + self._length - 2]), "<f4").reshape(-1, 4)

    def _found(self, at: int) -> Found:
        with np.errstate(invalid="ignore"):  # a signalling NaN may come over the wire
            values = self._numbers(at)[:, 1:].astype(np.float64)
        return Found(at, self._length, Reading(values, self._begin + at + self._length))


class ReskinEncoder(Encoder):
    """Encodes frames of chips at room temperature."""

    def __init__(self, options: Options) -> None:
        pass

    def encode(self, boards: Sequence[Taxels], sequence: int, t_device: float) -> bytes:
        """Return one frame with the chips of all boards."""
        values = np.concatenate(boards)
        values = np.where(np.abs(values) < FIELD[0], 0.0, values)  # less than a chip can tell from nothing
        return np.column_stack((np.full(len(values), ROOM_TEMPERATURE), values)).astype("<f4").tobytes() + END


FORMATS = {
    "reskin": Format(
        "reskin",
        "ReSkin / AnySkin magnetometer boards",
        115200,
        1000.0,
        ReskinDecoder,
        ReskinEncoder,
        calibrated=lambda options: False,
    )
}
