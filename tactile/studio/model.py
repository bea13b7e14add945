"""ArrayModel: what one page shows of a feed, as replies to its messages."""

import math
from collections.abc import Callable, Mapping
from dataclasses import replace
from typing import Any, Protocol

import numpy as np

from cnnsim.studio.colours import indices
from cnnsim.studio.message import Message
from cnnsim.support import InputError
from cnnsim.support.errors import not_known, shown
from cnnsim.support.values import is_number
from tactile.calibration.tare_check import UNITS
from tactile.core.frame import TaxelArray
from tactile.inverse.validity import Validity
from tactile.output.collected import texture_mean
from tactile.output.event_data import finite, load_data
from tactile.output.plot_labels import COLOURS, MINOR, OWN
from tactile.output.plot_plane import ARROWS, REACH, SURE, round_number
from tactile.studio.feed import Feed, Kept
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
        """Return ``rate``, ``losses``, ``state``, ``recording`` and ``warning`` as text."""

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
            "arrays": [_array(array) for array in feed.arrays], "kinds": kinds, "own": colors.to_hex(OWN),
            "minor": MINOR, "arrow": colors.to_hex("tab:blue"), "reach": REACH, "arrows": ARROWS, "span": SPAN,
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
        content |= {"status": self.link.status()} if self.link else {"status": _recorded_rate(feed)}
        if t is None:
            return Message(content | {"fingers": []})
        buffers: list[bytes] = []
        fingers = [None if row is None else _finger(row, buffers) for row in feed.at(t)]
        content |= {"t": t, "times": feed.times, "fingers": fingers}
        content["scales"] = {array.quantity: _scale(feed, array) for array in feed.arrays}
        events = [_event(one) for one in feed.events_between(t - SPAN, t)[-MOST_EVENTS:]]
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
        changed = {
            "shear": shear or settings.shear, "contact": contact or settings.contact,
            "sigmas": settings.sigmas if chosen.sigmas is None else sigmas,
        }  # fmt: skip
        begin = t - WINDOW
        found = self.feed.again(replace(settings, **changed), begin, t)
        now = [one for one in self.feed.events_between(begin, t) if one.t >= begin]
        content = {"is": "again", "begin": begin, "t": t, "seconds": WINDOW, "events": [_event(one) for one in found]}
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
        return Message({"is": "done", "text": self._port().record(message.content.get("on") is True)})


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


def _array(array: TaxelArray) -> dict[str, Any]:
    factor, unit = UNITS[array.quantity]
    return {
        "name": array.name, "rows": array.rows, "cols": array.cols, "pitch": array.pitch, "depth": array.depth,
        "origin": array.origin, "quantity": array.quantity, "factor": factor, "unit": unit,
        "inward": 1 if array.quantity == "force" else -1,
    }  # fmt: skip


def _finger(row: Kept, buffers: list[bytes]) -> dict[str, Any]:
    """Return a report as plain data; its values (rows, cols, 3) and the planes of programs go to the buffers."""
    report, code = row.report, row.report.code
    values = np.where(report.frame.valid[..., None], report.frame.values, np.nan)
    buffers.append(values.astype(np.float32).tobytes())
    load, outputs = load_data(report.load), []
    for program, named in row.outputs.items():
        for name, value in named.items():
            plane = np.asarray(value)
            if plane.ndim == 2:
                logic = plane.dtype.kind == "b"
                buffers.append(indices(np.nan_to_num(np.where(plane, 1.0, -1.0) if logic else plane)).tobytes())
                outputs.append({"program": program, "name": name, "shape": plane.shape})
            else:
                outputs.append({"program": program, "name": name, "value": plane.ravel()[:8].tolist()})
    if load is not None:
        load["sure"] = report.load.validity in SURE
    bits = "".join("1" if sign == "+" else "0" for sign in code.ternary())
    return {
        "t": row.t, "load": load, "arrows": code.arrows(), "bits": bits, "contact": int(code.contact.sum()),
        "validity": Validity(report.load.validity).name.lower().replace("_", " "), "outputs": outputs,
        "friction": finite(texture_mean(report.texture.friction, report.texture.valid)),
        "roughness": finite(texture_mean(report.texture.roughness, report.texture.valid)),
    }  # fmt: skip


def _scale(feed: Feed, array: TaxelArray) -> dict[str, float]:
    normal, shear = feed.largest(array.quantity)
    factor = UNITS[array.quantity][0]
    return {"normal": normal, "shear": shear, "key": round_number(shear * factor) / factor}


def _event(event: Any) -> dict[str, Any]:
    return {"t": event.t, "end": event.end, "finger": event.finger, "kind": event.kind, "words": event.words}


def _recorded_rate(feed: Feed) -> dict[str, Any]:
    rates = [
        (len(rows) - 1) / (rows[-1].t - rows[0].t) for rows in feed.rows if len(rows) > 1 and rows[-1].t > rows[0].t
    ]
    counts = getattr(feed.source, "counts", None)
    return {"rate": f"{sum(rates):.0f} frames/s", "losses": "" if counts is None else str(counts), "state": "",
            "recording": "", "warning": ""}  # fmt: skip


def _choices(content: Mapping[str, Any]) -> ThresholdChoices:
    """Return the thresholds of a message.

    Raises:
        InputError: a value that is no number.
    """
    names = ("dead_band", "hysteresis", "contact_level")
    found = {name: content.get(name) for name in names}
    sigmas = content.get("sigmas")
    values = [one for one in found.values() if one is not None] + (sigmas if isinstance(sigmas, list) else [])
    if not all(is_number(one) for one in values) or not (
        sigmas is None or (isinstance(sigmas, list) and len(sigmas) == 3)
    ):
        raise InputError("a threshold that is no number; dead_band, hysteresis, contact_level and three sigmas wanted")
    return ThresholdChoices(**found, sigmas=None if sigmas is None else tuple(sigmas))


def _options(chosen: ThresholdChoices) -> str:
    """Return the thresholds as options of `tactile run` and `tactile live`."""
    named = {"dead-band": chosen.dead_band, "hysteresis": chosen.hysteresis, "contact-level": chosen.contact_level}
    parts = [f"--{name} {value:g}" for name, value in named.items() if value is not None]
    if chosen.sigmas is not None:
        parts.append("--sigmas " + " ".join(f"{value:g}" for value in chosen.sigmas))
    return " ".join(parts)
