"""Publishing of frames as UDP datagrams, in JSON or MessagePack, for control loops in other programs."""

import socket
from collections.abc import Callable
from typing import Any
from urllib.parse import urlsplit

import numpy as np

from cnnsim.support import InputError
from tactile.core.frame import TaxelArray
from tactile.output.stream_frame import StreamFrame, frame_json

HOST = "127.0.0.1"
LARGEST = 65_507
"""Largest datagram over IPv4 in bytes."""
WORDY = 16
"""Bytes of a number in JSON."""
BUFFER = 2**20
"""Bytes of the send buffer."""


def udp_address(text: str) -> tuple[str, int]:
    """Return host and port of udp://HOST:PORT; the host is 127.0.0.1 unless given.

    Raises:
        InputError: another form.
    """
    try:
        url = urlsplit(text)
        port = url.port
    except ValueError:
        url, port = urlsplit(""), None
    if url.scheme != "udp" or not port or url.path.strip("/") or url.query:
        raise InputError(f"--publish {text!r}; udp://HOST:PORT wanted, such as udp://{HOST}:9000")
    return url.hostname or HOST, port


class Publisher:
    """An output of frames that sends each as a datagram: JSON, or MessagePack with the values as float32 bytes.

    ``unsent`` counts datagrams that the system did not take; sending never waits.

    Raises:
        InputError: another address than `udp_address` takes, an unknown host, an array too large for a datagram, or
            MessagePack is not installed.
    """

    def __init__(self, address: str, arrays: tuple[TaxelArray, ...], *, packed: bool = False) -> None:
        host, port = udp_address(address)
        for array in arrays:
            size = array.rows * array.cols * 3 * (4 if packed else WORDY)
            if size > LARGEST:
                raise InputError(
                    f"--publish: finger {array.name!r} of {array.rows} x {array.cols} taxels takes {size} bytes,"
                    f" a datagram {LARGEST}; {'a smaller array' if packed else '--msgpack or a smaller array'} wanted"
                )
        self.address, self.sent, self.unsent = address, 0, 0
        self._encode = _packer() if packed else frame_json
        try:
            found = socket.getaddrinfo(host, port, type=socket.SOCK_DGRAM)
            kind, _, _, _, to = min(found, key=lambda one: one[0] != socket.AF_INET)  # as listeners mostly do
        except OSError as error:
            raise InputError(f"--publish {address}: {error.strerror or error}") from error
        self._to: Any = to  # its form depends on the kind of address
        self._socket = socket.socket(kind, socket.SOCK_DGRAM)
        self._socket.setsockopt(socket.SOL_SOCKET, socket.SO_SNDBUF, BUFFER)
        self._socket.setblocking(False)

    def __call__(self, frame: StreamFrame, data: dict[str, Any]) -> None:
        """Send a frame."""
        try:
            self._socket.sendto(self._encode(frame, data), self._to)
            self.sent += 1
        except OSError:  # no room, no route: the loop goes on without this frame
            self.unsent += 1

    def close(self) -> None:
        """Close the socket."""
        self._socket.close()


def _packer() -> Callable[[StreamFrame, dict[str, Any]], bytes]:
    try:
        import msgpack  # type: ignore[import-untyped]  # it ships no types
    except ModuleNotFoundError as error:
        from cnnsim.support.extras import install_line

        raise InputError(f"--msgpack needs msgpack, which is not installed: {install_line('serial')}") from error

    def pack(frame: StreamFrame, data: dict[str, Any]) -> bytes:
        values = np.where(frame.valid[..., None], frame.values, np.nan).astype("<f4")
        packed: bytes = msgpack.packb(data | {"values": values.tobytes(), "shape": values.shape})
        return packed

    return pack
