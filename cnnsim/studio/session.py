"""Session: the model of the playground, which answers the messages of one page."""

from collections.abc import Callable
from typing import Any, get_args

from cnnsim import backends
from cnnsim.library.write import template_keys
from cnnsim.network import CellModel, LayeredTemplate
from cnnsim.planning.scheme import ADAPTIVE, SCHEMES
from cnnsim.studio import cell, drawing, explore, exports, programs, shelf
from cnnsim.studio.colours import indices
from cnnsim.studio.link import link_of, read_link
from cnnsim.studio.message import Message
from cnnsim.studio.pictures import NAMES
from cnnsim.studio.run import Run
from cnnsim.studio.setup import Setup, boundary_text, changed, first_setup
from cnnsim.support import Array, InputError
from cnnsim.support.errors import not_known
from cnnsim.support.notices import Notices

FRAME_SECONDS = 0.1
"""How long a page waits for a frame at most; it then shows the state that is reached and asks again."""
MOST_STEPS = 10**6
"""Steps of a run: a network with delays takes all of them for a frame."""
Handler = Callable[["Session", Message], Message]


class Session:
    """A setup and its run; `receive` answers what a page does."""

    def __init__(self, setup: Setup | None = None) -> None:
        self.setup = setup or first_setup("hole-filler")
        self.run = self._new_run(self.setup)
        self.chips: explore.Chips | None = None
        self.precision: explore.Precision | None = None

    def receive(self, message: Message) -> Message:
        """Return the reply to a message; its key "do" names what is to be done.

        Raises:
            InputError: the message, or what it asks for, is wrong; nothing has changed then.
        """
        name = message.text("do")
        if name not in HANDLERS:
            raise not_known("do", name, tuple(HANDLERS))
        notices: list[str] = []
        before, Notices.tell = Notices.tell, notices.append
        try:
            reply = HANDLERS[name](self, message)
        finally:
            Notices.tell = before
        if notices:
            reply.content["notice"] = notices[-1]
        if "id" in message.content:
            reply.content["id"] = message.content["id"]
        return reply

    def change(self, setup: Setup, *, live: bool = False) -> None:
        """Take a new setup; the run begins again, or with ``live`` goes on from its present state.

        Raises:
            InputError: the setup cannot run; the old one stays.
        """
        before = self.run
        run = self._new_run(setup)
        fits = run.x.shape == before.x.shape and run.step == before.step
        if live and fits and not run.timed and before.index:
            run = Run(run.task, run.backend, before.index, before.x.astype(run.x.dtype))
        self.setup, self.run, self.chips, self.precision = setup, run, None, None

    def paint(self, state: Array) -> None:
        """Take another present state; what was before is forgotten.

        Raises:
            InputError: the network depends on its past.
        """
        if self.run.timed:
            raise InputError("a network with delays or sequences depends on its past: draw in the input instead")
        self.run = Run(self.run.task, self.run.backend, self.run.index, state)

    @staticmethod
    def _new_run(setup: Setup) -> Run:
        backend = backends.get("reference" if setup.scheme == ADAPTIVE else setup.backend)
        duration: dict[str, Any] = {}
        if setup.scheme == ADAPTIVE and setup.entry.duration == "settled":
            duration["duration"] = 10.0
        return Run(setup.task(**duration), backend)

    def layers(self) -> int:
        """Return the number of layers."""
        network = self.setup.entry.network
        return len(network.layers) if isinstance(network, LayeredTemplate) else 1

    def layer(self, plane: Array, message: Message) -> Array:
        """Return the layer of a plane that a message asks for."""
        number = message.whole("layer", 0, self.layers() - 1, 0)
        return plane[number] if plane.ndim == 3 else plane

    def described(self) -> dict[str, Any]:
        """Return what the page shows besides planes."""
        setup, entry, run = self.setup, self.setup.entry, self.run
        return {
            "is": "planes", "name": entry.name, "summary": entry.summary, "reference": entry.reference,
            "note": entry.note, "network": template_keys(entry.network), "layers": self.layers(),
            "changed": setup.changed, "input": entry.input, "initial_state": entry.initial_state,
            "second": setup.takes_second, "frames": len(setup.picture) if setup.picture.ndim == 3 else 0,
            "boundary": boundary_text(entry.boundary), "cell": entry.cell.model, "duration": entry.duration,
            "scheme": setup.scheme, "step": entry.step, "accuracy": entry.accuracy, "backend": setup.backend,
            "index": run.index, "shape": setup.grid, "made": setup.made, "examples": len(entry.examples), "h": run.step,
            "plan": run.task.plan.decisions, "link": link_of(setup),
            "where": f"{run.backend.name}, {run.backend.dtype}",
        }  # fmt: skip


def _open(session: Session, message: Message) -> Message:
    """Take the setup of a link, or a template on the present picture; the reply has the choices that a page offers."""
    if link := message.text("link", ""):
        session.change(read_link(link))
    reply = _planes(session, message)
    known = {
        "boundaries": ["zero-flux", "periodic", "fixed:0", "fixed:-1", "fixed:1"],
        "cells": list(get_args(CellModel)),
        "schemes": [*SCHEMES, ADAPTIVE],
        "backends": _installed(),
        "pictures": list(NAMES),
    }
    reply.content["known"] = known
    return reply


def _installed() -> list[str]:
    from importlib.util import find_spec

    return [name for name in backends.NAMES if name != "opencl" or find_spec("pyopencl") is not None]


def _planes(session: Session, message: Message) -> Message:
    """Reply with the description, the input and the initial state."""
    setup, run = session.setup, session.run
    number = message.whole("frame", 0, 10**6, 0)
    start = session.layer(run.kept[run.first], message)
    shown = setup.picture if setup.picture.ndim == 2 else setup.picture[min(number, len(setup.picture) - 1)]
    return Message(session.described(), [indices(shown).tobytes(), indices(start).tobytes()])


def _set(session: Session, message: Message) -> Message:
    changes = message.content.get("changes")
    if not isinstance(changes, dict):
        raise InputError("changes are missing; an object wanted")
    before = session.setup
    session.change(changed(before, changes), live=message.content.get("live") is True)
    if session.setup.entry.initial_state == before.entry.initial_state and session.run.first:
        return Message(session.described())  # the planes are those that the page has
    return _planes(session, message)


def _frame(session: Session, message: Message) -> Message:
    """Go ``by`` steps on, or ``to`` an index, and reply with the state (or output) that was reached in time."""
    run = session.run
    seconds, steps, begin = run.seconds, run.cell_steps, run.index
    by = message.whole("by", -(10**6), 10**6, 0)
    to = message.whole("to", 0, MOST_STEPS, run.index + by)
    ends = message.content.get("rest") is True
    if ends and by > 0 and run.last is not None and run.index < run.last:
        to = min(to, run.last)
    arrived = run.go(to, FRAME_SECONDS)
    every = max(1, round(1 / run.step))
    ended = ends and (run.index == run.last or (run.index // every != begin // every and run.settled()))
    shown = session.layer(run.y if message.content.get("show") == "y" else run.x, message)
    content = {
        "is": "frame", "index": run.index, "t": run.t, "first": run.first, "arrived": arrived, "ended": ended,
        "settled": ended and run.index != run.last, "last": run.last, "shape": shown.shape,
        "seconds": run.seconds - seconds, "cell_steps": run.cell_steps - steps,
    }  # fmt: skip
    return Message(content, [indices(shown).tobytes()])


HANDLERS: dict[str, Handler] = {
    "open": _open,
    "planes": _planes,
    "set": _set,
    "frame": _frame,
    **drawing.HANDLERS,
    **cell.HANDLERS,
    **shelf.HANDLERS,
    **explore.HANDLERS,
    **programs.HANDLERS,
    **exports.HANDLERS,
}
"""What a page can ask for."""
