"""Playground: the picture view of the studio as a widget of notebooks (Jupyter, VS Code, marimo)."""

from dataclasses import replace
from typing import Any

import anywidget
import numpy as np
from numpy.typing import ArrayLike

from cnnsim.library.entry import LibraryEntry
from cnnsim.network import AnyTemplate
from cnnsim.studio import PAGE
from cnnsim.studio.message import Message, reply_to
from cnnsim.studio.session import Session
from cnnsim.studio.setup import Setup, changed, first_setup, given_setup
from cnnsim.support import Array
from cnnsim.support.values import as_picture


def _module(*names: str) -> str:
    """Return modules of the page as one, without their imports of each other."""
    lines = [line for name in names for line in (PAGE / name).read_text(encoding="utf-8").splitlines()]
    return "\n".join(line for line in lines if not line.startswith("import "))


class Playground(anywidget.AnyWidget):
    """A template at work on a picture, which can be drawn in; `change` acts while it runs.

    Playground("hole-filler", picture)

    Arguments: ``template`` a name of the library, an entry, or a template of your own, which has x(0) = u = the picture
    and runs until it settles; ``picture`` (rows, cols) of CNN values, None for one to begin with; ``changes`` as in
    `change`.

    Raises:
        InputError: no such template, a picture that does not fit, or a wrong change.
    """

    _esm = _module("base.js", "pane.js", "controls.js", "view.js")
    _css = PAGE / "view.css"

    def __init__(
        self, template: str | LibraryEntry | AnyTemplate = "hole-filler", picture: ArrayLike | None = None,
        **changes: Any,
    ) -> None:  # fmt: skip
        super().__init__()
        setup = _setup(template)
        if picture is not None:
            setup = setup.with_picture(np.asarray(as_picture("picture", picture), np.float64))
        self.session = Session(_changed(setup, changes))
        self.on_msg(self._answer)

    def _answer(self, _widget: Any, content: Any, buffers: Any) -> None:
        message = Message(content if isinstance(content, dict) else {}, [bytes(buffer) for buffer in buffers or ()])
        reply = reply_to(self.session, message)
        self.send(reply.content, reply.buffers)

    def change(self, **changes: Any) -> None:
        """Change the run as it goes: template, boundary, cell, scheme, step, accuracy, duration, backend.

        ``template`` are other numbers, as a template; the others are as in `cnnsim.run_transient`.

        Raises:
            InputError: a change that cannot run; nothing has changed then.
        """
        self.session.change(_changed(self.session.setup, changes), live=True)
        self._answer(self, {"do": "planes"}, [])

    @property
    def template(self) -> AnyTemplate:
        """The template as it is now."""
        return self.session.setup.entry.network

    @property
    def t(self) -> float:
        """The time of the picture that is shown [time constants]."""
        return self.session.run.t

    @property
    def x(self) -> Array:
        """The state that is shown."""
        return self.session.run.x.copy()

    @property
    def y(self) -> Array:
        """Its output."""
        return self.session.run.y.copy()


def _setup(template: str | LibraryEntry | AnyTemplate) -> Setup:
    if isinstance(template, str):
        return given_setup(template, None)
    usual = first_setup("copy")
    if not isinstance(template, LibraryEntry):
        template = LibraryEntry(template.name, "a template of your own", "", template)
    return replace(usual, entry=template, own=template).on_grid(usual.grid)


def _changed(setup: Setup, changes: dict[str, Any]) -> Setup:
    network = changes.pop("template", None)
    setup = changed(setup, changes)
    return setup if network is None else replace(setup, entry=replace(setup.entry, network=network))
