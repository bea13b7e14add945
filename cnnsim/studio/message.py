"""Messages between a page and its model: a JSON object with buffers of bytes, and the reading of its values."""

import json
import math
from dataclasses import dataclass, field
from typing import Any, Protocol

from cnnsim.support import InputError
from cnnsim.support.errors import shown
from cnnsim.support.terminal import echo
from cnnsim.support.values import is_number, is_whole

MOST_BYTES = 8 * 2**20
"""Bytes of a message from a page."""


@dataclass
class Message:
    """A JSON object ``content`` and buffers."""

    content: dict[str, Any]
    buffers: list[bytes] = field(default_factory=list)

    def text(self, key: str, default: str | None = None) -> str:
        """Return a text of at most a million characters.

        Raises:
            InputError: it is missing, or no text.
        """
        value = self.content.get(key, default)
        if not isinstance(value, str) or len(value) > 10**6:
            raise InputError(f"{key} = {shown(value)}; a text wanted")
        return value

    def whole(self, key: str, least: int, most: int, default: int | None = None) -> int:
        """Return a whole number.

        Raises:
            InputError: it is missing, or outside of [least, most].
        """
        value = self.content.get(key, default)
        if not is_whole(value) or not least <= value <= most:
            raise InputError(f"{key} = {shown(value)}; a whole number from {least} to {most} wanted")
        return int(value)

    def number(self, key: str, least: float, most: float, default: float | None = None) -> float:
        """Return a number.

        Raises:
            InputError: it is missing, or outside of [least, most].
        """
        value = self.content.get(key, default)
        if not is_number(value) or not least <= value <= most:
            raise InputError(f"{key} = {shown(value)}; a number from {least:g} to {most:g} wanted")
        return float(value)

    def buffer(self) -> bytes:
        """Return the only buffer.

        Raises:
            InputError: there is none, or several.
        """
        if len(self.buffers) != 1:
            raise InputError(f"{len(self.buffers)} buffers; one wanted")
        return bytes(self.buffers[0])


class Model(Protocol):
    """What a page shows; it is called by one thread."""

    def receive(self, message: Message) -> Message:
        """Return the reply to a message."""


def reply_to(model: Model, message: Message) -> Message:
    """Return the reply of a model; an error is a reply as well, with its ``text``."""
    try:
        return model.receive(message)
    except InputError as error:
        text = str(error)
    except Exception as error:  # an error in the studio's own code must not close the page
        text = f"an error of the studio: {type(error).__name__}: {error}"
        echo(text, err=True)
    said = {key: value for key, value in message.content.items() if key in ("do", "id")}
    return Message({"is": "error", "text": text, **said})


def pack(message: Message) -> str | bytes:
    """Return a message as text, or with buffers as bytes: length of the JSON (4 bytes, little-endian), JSON, buffers.

    The JSON then has the ``sizes`` of the buffers.
    """
    if not message.buffers:
        return json.dumps(_plain(message.content), allow_nan=False)
    content = {**message.content, "sizes": [len(buffer) for buffer in message.buffers]}
    head = json.dumps(_plain(content), allow_nan=False).encode()
    return b"".join([len(head).to_bytes(4, "little"), head, *message.buffers])


def unpack(data: str | bytes) -> Message:
    """Return the message of a text or of bytes.

    Raises:
        InputError: no JSON object, or buffers of other sizes than it says.
    """
    head, rest = data, b""
    if isinstance(data, bytes):
        length = int.from_bytes(data[:4], "little")
        head, rest = data[4 : 4 + length], data[4 + length :]
    try:
        content = json.loads(head)
    except (ValueError, RecursionError) as error:
        raise InputError(f"a message that is no JSON: {type(error).__name__}") from error
    if not isinstance(content, dict):
        raise InputError(f"a message {shown(content)}; an object wanted")
    sizes = content.pop("sizes", [])
    if not (isinstance(sizes, list) and all(is_whole(n) and n >= 0 for n in sizes) and sum(sizes) == len(rest)):
        raise InputError(f"buffers of {shown(sizes)} bytes in a message with {len(rest)}; equal ones wanted")
    buffers, begin = [], 0
    for size in sizes:
        buffers.append(rest[begin : begin + size])
        begin += size
    return Message(content, buffers)


def _plain(value: Any) -> Any:
    """Return a value of which every number is finite, as JSON wants it: None for NaN and infinities."""
    if isinstance(value, dict):
        return {str(key): _plain(item) for key, item in value.items()}
    if isinstance(value, list | tuple):
        return [_plain(item) for item in value]
    if hasattr(value, "item") and not hasattr(value, "__len__"):
        value = value.item()
    return None if isinstance(value, float) and not math.isfinite(value) else value
