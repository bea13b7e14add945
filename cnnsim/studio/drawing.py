"""Drawing in planes, and other pictures for them."""

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from cnnsim.studio.colours import values
from cnnsim.studio.message import Message
from cnnsim.studio.pictures import SIDES, make_picture, with_noise
from cnnsim.support import InputError

if TYPE_CHECKING:
    from cnnsim.studio.session import Session


def _draw(session: "Session", message: Message) -> Message:
    """Put a rectangle of palette indices into the input, the initial state or the present state."""
    setup, plane = session.setup, message.text("plane")
    rows, cols = setup.grid
    row, col = message.whole("row", 0, rows - 1), message.whole("col", 0, cols - 1)
    size = message.whole("rows", 1, rows - row), message.whole("cols", 1, cols - col)
    patch = values(message.buffer(), size)
    where = np.s_[row : row + size[0], col : col + size[1]]
    if plane == "state":
        x = session.run.x.copy()
        session.layer(x, message)[where] = patch
        session.paint(x)
        return Message({"is": "drawn"})
    if plane == "start":
        roles = setup.entry.initial_state
        if isinstance(roles, tuple) and not setup.takes_second:
            raise InputError("x(0) of this network of layers is given by its file")
        start = np.array(session.layer(session.run.task.state, message), np.float64).clip(-1, 1)
        start[where] = patch
        entry = setup.entry if setup.takes_second else replace(setup.entry, initial_state="given")
        session.change(replace(setup, entry=entry, second=start))
        return _replied(session, message)
    picture = setup.picture.copy()
    if picture.ndim == 3:
        picture[message.whole("frame", 0, len(picture) - 1, 0)][where] = patch
    else:
        picture[where] = patch
    session.change(replace(setup, picture=picture, made=None), live=message.content.get("live") is True)
    return _replied(session, message)


def _picture(session: "Session", message: Message) -> Message:
    """Take a made picture, one from the page (bytes), another size of the grid, or noise on the present picture."""
    setup = session.setup
    grid = (message.whole("rows", *SIDES, setup.grid[0]), message.whole("cols", *SIDES, setup.grid[1]))
    seed = message.whole("seed", 0, 10**9, 0)
    if message.buffers:
        setup = setup.with_picture(values(message.buffer(), grid))
    elif "noise" in message.content:
        setup = setup.with_picture(with_noise(setup.picture, message.number("noise", 0, 10), seed))
    elif "name" in message.content:
        made = message.text("name"), seed
        setup = setup.with_picture(make_picture(made[0], grid, seed), made)
    else:
        setup = setup.on_grid(grid)
    session.change(setup)
    return _replied(session, message)


def _replied(session: "Session", message: Message) -> Message:
    """Reply with the layer and the frame that the page shows."""
    return session.receive(Message({**message.content, "do": "planes"}))


HANDLERS = {"draw": _draw, "picture": _picture}
