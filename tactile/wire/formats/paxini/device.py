"""Emulated Paxini PX-6AX GEN3 boards: frames, and the requests they handle.

The high-speed board pushes frames. It handles writes to the push and data type registers and the calibration, and reads
of these, the module bitmap and the point counts. The serial converter board handles reads of the points and the
calibration. Other requests are answered with an error: function + 80, or status 4 or 2.
"""

import struct
from abc import abstractmethod
from collections.abc import Sequence

import numpy as np

from tactile.wire.base import Encoder, Options
from tactile.wire.device_tare import DeviceTare
from tactile.wire.formats.paxini import packet as px
from tactile.wire.reading import Taxels

SETTLE = 0.1
"""[s] Averaging time of a calibration."""
BAD_CHECK, BAD_COMMAND = 0x02, 0x04


class PaxiniEncoder(Encoder):
    """Finds the host's requests in what is received."""

    head: int

    def __init__(self) -> None:
        self._tare, self._received = DeviceTare(SETTLE), bytearray()

    def receive(self, data: bytes) -> bytes:
        """Handle every complete request; noise before a request is skipped."""
        self._received += data
        said = b""
        while True:
            at = self._received.find(px.REQUEST)
            del self._received[: at if at >= 0 else max(0, len(self._received) - 1)]
            if at < 0 or len(self._received) < self.head:
                return said
            length = self._length(bytes(self._received[2 : self.head]))
            if length > px.LONGEST:
                del self._received[:1]
            elif len(self._received) < length:
                return said
            else:
                said += self._answer(bytes(self._received[:length]))
                del self._received[:length]

    @abstractmethod
    def _length(self, head: bytes) -> int:
        """Return the length of the request at the start."""

    @abstractmethod
    def _answer(self, request: bytes) -> bytes:
        """Handle a request and return the answer."""


class PushEncoder(PaxiniEncoder):
    """Encodes frames of the high-speed board."""

    head = 2 + px.FAST.size

    def __init__(self, options: Options) -> None:
        super().__init__()
        self._kinds, self._pushing, self._taxels = 2 + px.resultant(options), True, options.taxels

    def encode(self, boards: Sequence[Taxels], sequence: int, t_device: float) -> bytes:
        """Return one push frame of all modules, nothing while pushing is switched off."""
        boards = self._tare(boards, t_device)
        if not self._pushing:
            return b""
        data = b""
        for values in boards:
            if self._kinds & 1:
                data += np.clip(np.rint(values.sum(0) / px.NEWTON), -(2**15), 2**15 - 1).astype("<i2").tobytes()
            if self._kinds & 2:
                data += px.encode_points(values)
        return _pushed(data)

    def _length(self, head: bytes) -> int:
        _, function, _, dlen = px.FAST.unpack(head)
        return 9 + (0 if function == px.READ else dlen)

    def _answer(self, request: bytes) -> bytes:
        _, function, register, dlen = px.FAST.unpack_from(request, 2)
        data, right = request[8:-1], px.lrc(request[:-1]) == request[-1]
        if right and function == px.READ and (there := self._registers().get(register)) is not None:
            return self._reply(function, register, there[:dlen])
        if right and (function, register, data[1:]) == (px.WRITE, px.AUTO_PUSH, b""):
            self._pushing = data != b"\0"
            return _pushed(b"")  # the answer to this request has the form of a push
        if right and (function, register, data[1:]) == (px.WRITE, px.DATA_TYPE, b"") and data in (b"\1", b"\2", b"\3"):
            self._kinds = data[0]
            return self._reply(function, register, b"\0")
        if right and (function, register, data) == (px.CALIBRATE, px.ZERO, b"\1"):
            self._tare.ask()
            return self._reply(function, register, b"\0")
        return self._reply(function | 0x80, register, b"")

    def _registers(self) -> dict[int, bytes]:
        """Contents of the readable registers; the modules are in the first slots."""
        modules = ((1 << len(self._taxels)) - 1).to_bytes(4, "little")
        counts = struct.pack(f"<{len(self._taxels)}H", *self._taxels).ljust(56, b"\0")
        each = {px.POINT_COUNTS + 2 * n: counts[2 * n :] for n in range(28)}
        return each | {px.MODULES: modules, px.DATA_TYPE: bytes([self._kinds]), px.AUTO_PUSH: bytes([self._pushing])}

    @staticmethod
    def _reply(function: int, register: int, data: bytes) -> bytes:
        return px.closed(px.REPLY + px.FAST.pack(0, function, register, len(data)) + data)


class AnswerEncoder(PaxiniEncoder):
    """Encodes answers of the serial converter board."""

    head, polled = 2 + px.SLOW.size, True

    def __init__(self, options: Options) -> None:
        super().__init__()
        self._read = px.slow_request(px.READ_FORCE, px.POINTS_ADDRESS, count=3 * px.one_module(options))

    def encode(self, boards: Sequence[Taxels], sequence: int, t_device: float) -> bytes:
        """Return the answer with the points of the only module."""
        data = px.encode_points(self._tare(boards, t_device)[0])
        head = px.SLOW.pack(len(data) + 10, 1, 0, px.READ_FORCE, px.POINTS_ADDRESS, len(data))
        return px.closed(px.REPLY + head + b"\1" + data)  # status 1 comes with valid data

    def _length(self, head: bytes) -> int:
        return int(px.SLOW.unpack(head)[0]) + 5

    def _answer(self, request: bytes) -> bytes:
        if request == self._read:
            self.asked += 1
            return b""
        if len(request) < self.head + 1:
            return b""
        _, device, _, function, address, dlen = px.SLOW.unpack_from(request, 2)
        status = 0
        if px.lrc(request[:-1]) != request[-1]:
            status = BAD_CHECK
        elif (function, address, request[13:-1]) == (px.CALIBRATE_ONE, px.ZERO_ADDRESS, b"\1"):
            self._tare.ask()
        else:
            status = BAD_COMMAND
        return px.closed(px.REPLY + px.SLOW.pack(10, device, 0, function, address, dlen) + bytes([status]))


def _pushed(data: bytes) -> bytes:
    return px.closed(px.PUSH + b"\0" + struct.pack("<HB", len(data) + 1, 0) + data)
