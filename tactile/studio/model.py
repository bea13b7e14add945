"""ArrayModel: what one page shows of a feed, as replies to its messages."""

import math
from collections.abc import Callable, Mapping
from dataclasses import replace
from typing import Any, Protocol

import numpy as np

from cnnsim.studio.message import Message
from cnnsim.support import InputError
from cnnsim.support.errors import not_known, shown
from cnnsim.support.values import is_number
from tactile.output.collected import texture_mean
from tactile.output.plane import ARROWS
from tactile.output.plot_events import COLOURS, MINOR, OWN
from tactile.output.plot_plane import ARROW, REACH
from tactile.studio.feed import Feed
from tactile.studio.frame_data import array_data, finger_data, recorded_rate, scale_data, span_data
from tactile.thresholds.choices import ThresholdChoices
from tactile.thresholds.threshold import CONTACT, SHEAR

SPAN = 10.0
"""[s] Time of the ribbon and of the curves."""
WINDOW = 5.0
"""[s] Time whose events are computed again with other thresholds."""
POINTS = 300
"""Points of a curve, at most."""
MOST_EVENTS = 300
"""Events of a ribbon, the newest."""


class Link(Protocol):
    """The port of a feed."""

    def status(self) -> dict[str, Any]:
        """Return ``rate``, ``losses``, ``state``, ``recording``, ``warning``, ``lost`` and ``answer`` as text."""

    def tare(self, force: bool) -> None:
        """Request a tare."""

    def record(self, on: bool) -> str:
        """Begin or end a recording and return a text about it."""


class ArrayModel:
    """A page's view of a feed; ``link`` is the port, None for a recording or a scene."""

    def __init__(self, feed: Feed, link: Link | None = None) -> None:
        self.feed, self.link = feed, link
        self._sent: list[dict[str, Any]] | None = None

    def receive(self, message: Message) -> Message:
        """Return the reply to a message; its key "do" names what is to be done.

        Raises:
            InputError: the message, or what it asks for, is wrong.
        """
        name = message.text("do")
        if name not in HANDLERS:
            raise not_known("do", name, tuple(HANDLERS))
        reply = HANDLERS[name](self, message)
        if "id" in message.content:
            reply.content["id"] = message.content["id"]
        return reply

    def _time(self, message: Message) -> float | None:
        """Return the time that a page shows: the newest if it names none; None before the first report."""
        times, t = self.feed.times, message.content.get("t")
        if t is not None and not (is_number(t) and math.isfinite(t)):
            raise InputError(f"t = {shown(t)}; a time [s] wanted")
        return None if times is None else times[1] if t is None else float(min(max(t, times[0]), times[1]))

    def _open(self, _message: Message) -> Message:
        """Reply with the arrays, the colours of the pictures of `tactile run`, and the thresholds."""
        from matplotlib import colormaps, colors  # slow to import

        self._sent = None
        feed, settings = self.feed, self.feed.settings
        quantity = feed.arrays[0].quantity
        shear, contact = settings.shear or SHEAR[quantity], settings.contact or CONTACT[quantity]
        kinds = {kind: colors.to_hex(colour) for kind, colour in COLOURS.items()}
        content = {
            "is": "open", "title": feed.source.title, "live": feed.live, "port": self.link is not None,
            "arrays": [array_data(array) for array in feed.arrays], "kinds": kinds, "own": colors.to_hex(OWN),
            "minor": MINOR, "arrow": ARROW, "reach": REACH, "arrows": ARROWS, "span": SPAN,
            "thresholds": {
                "dead_band": shear.dead_band, "hysteresis": shear.hysteresis, "contact_level": contact.dead_band,
                "sigmas": list(vars(settings.sigmas).values()),
            },
            "programs": list(settings.programs),
        }  # fmt: skip
        maps = [np.round(255 * colormaps[name](np.linspace(0, 1, 256))).astype(np.uint8) for name in ("Greys", "RdGy")]
        return Message(content, [one.tobytes() for one in maps])

    def _frame(self, message: Message) -> Message:
        """Reply with the newest report of each finger at a time, and the events before it if they have changed."""
        feed, t = self.feed, self._time(message)
        content: dict[str, Any] = {"is": "frame", "over": feed.over, "failure": feed.failure, "full": feed.full}
        content["compiling"] = feed.compiling
        content |= {"status": self.link.status()} if self.link else {"status": recorded_rate(feed)}
        if t is None:
            return Message(content | {"fingers": []})
        buffers: list[bytes] = []
        fingers = [None if row is None else finger_data(row, buffers) for row in feed.at(t)]
        content |= {"t": t, "times": feed.times, "fingers": fingers}
        content["scales"] = {array.quantity: scale_data(feed, array) for array in feed.arrays}
        events = [span_data(one) for one in feed.events_between(t - SPAN, t)[-MOST_EVENTS:]]
        if events != self._sent:
            content["events"] = self._sent = events
        return Message(content, buffers)

    def _series(self, message: Message) -> Message:
        """Reply with pressing, friction and roughness of each finger over time, as float32."""
        feed, t = self.feed, self._time(message)
        if t is None:
            return Message({"is": "series", "t": 0.0})
        buffers = []
        for finger in range(len(feed.arrays)):
            rows = feed.between(finger, t - SPAN, t, POINTS)
            textures = [row.report.texture for row in rows]
            found = [
                [row.t for row in rows], [row.report.load.F for row in rows],
                [texture_mean(one.friction, one.valid) for one in textures],
                [texture_mean(one.roughness, one.valid) for one in textures],
            ]  # fmt: skip
            buffers.append(np.array(found, np.float32).tobytes())
        return Message({"is": "series", "t": t}, buffers)

    def _thresholds(self, message: Message) -> Message:
        """Reply with the events of the last seconds under other thresholds, and with those of the run."""
        t, settings = self._time(message), self.feed.settings
        if t is None:
            raise InputError("no frame has come yet; frames wanted")
        chosen = _choices(message.content)
        shear, contact, sigmas = chosen.thresholds()
        settings = replace(
            settings, shear=shear or settings.shear, contact=contact or settings.contact,
            sigmas=settings.sigmas if chosen.sigmas is None else sigmas,
        )  # fmt: skip
        begin = t - WINDOW
        found = self.feed.again(settings, begin, t)
        now = [one for one in self.feed.events_between(begin, t) if one.t >= begin and one.told <= t]
        content = {
            "is": "again",
            "begin": begin,
            "t": t,
            "seconds": WINDOW,
            "events": [span_data(one) for one in found],
        }
        content |= {"count": sum(one.t >= begin for one in found), "now": len(now), "options": _options(chosen)}
        return Message(content)

    def _port(self) -> Link:
        if self.link is None:
            raise InputError("a recording or a scene has no port; a port wanted")
        return self.link

    def _tare(self, message: Message) -> Message:
        self._port().tare(message.content.get("force") is True)
        return Message({"is": "done", "text": "tare requested"})

    def _record(self, message: Message) -> Message:
        text = self._port().record(message.content.get("on") is True)
        return Message({"is": "done", "text": text, "warning": not text.startswith(("record", "nothing"))})


Handler = Callable[[ArrayModel, Message], Message]
HANDLERS: Mapping[str, Handler] = {
    "open": ArrayModel._open,
    "frame": ArrayModel._frame,
    "series": ArrayModel._series,
    "thresholds": ArrayModel._thresholds,
    "tare": ArrayModel._tare,
    "record": ArrayModel._record,
}
"""What a page can ask for."""


def _choices(content: Mapping[str, Any]) -> ThresholdChoices:
    """Return the thresholds of a message.

    Raises:
        InputError: a value that is no number.
    """
    dead_band, hysteresis, contact = (content.get(name) for name in ("dead_band", "hysteresis", "contact_level"))
    sigmas = content.get("sigmas")
    three: list[Any] = sigmas if isinstance(sigmas, list) and len(sigmas) == 3 else []
    values = [one for one in (dead_band, hysteresis, contact, *three) if one is not None]
    if not all(map(is_number, values)) or not (three or sigmas is None):
        raise InputError("a threshold that is no number; dead_band, hysteresis, contact_level and three sigmas wanted")
    return ThresholdChoices(dead_band, hysteresis, contact, None if sigmas is None else tuple(sigmas))


def _options(chosen: ThresholdChoices) -> str:
    """Return the thresholds as options of `tactile run` and `tactile live`."""
    named = {"dead-band": chosen.dead_band, "hysteresis": chosen.hysteresis, "contact-level": chosen.contact_level}
    parts = [f"--{name} {value:g}" for name, value in named.items() if value is not None]
    if chosen.sigmas is not None:
        parts.append("--sigmas " + " ".join(f"{value:g}" for value in chosen.sigmas))
    return " ".join(parts)
