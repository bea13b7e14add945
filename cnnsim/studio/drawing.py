"""Drawing in planes, and other pictures for them."""

from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np

from cnnsim.studio.colours import values
from cnnsim.studio.message import Message
from cnnsim.studio.pictures import SIDES, make_picture, with_noise
from cnnsim.support import Array

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
        own = setup.takes_second and setup.second is not None
        start = setup.second.copy() if own and setup.second is not None else _start_of(session, message)
        start[where] = patch
        roles = setup.entry.initial_state
        entry = (
            setup.entry
            if setup.takes_second or isinstance(roles, tuple)
            else replace(setup.entry, initial_state="given")
        )
        session.change(replace(setup, entry=entry, second=start))
        return session.receive(Message({"do": "planes", **_shown(message)}))
    picture = setup.picture.copy()
    if picture.ndim == 3:
        picture[message.whole("frame", 0, len(picture) - 1, 0)][where] = patch
    else:
        picture[where] = patch
    session.change(replace(setup, picture=picture, made=None), live=message.content.get("live") is True)
    return session.receive(Message({"do": "planes", **_shown(message)}))


def _start_of(session: "Session", message: Message) -> Array:
    state = np.array(session.layer(np.asarray(session.run.task.state), message), np.float64)
    return state.clip(-1, 1)


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
    return session.receive(Message({"do": "planes", **_shown(message)}))


def _shown(message: Message) -> dict[str, Any]:
    return {key: message.content[key] for key in ("layer", "frame") if key in message.content}


HANDLERS = {"draw": _draw, "picture": _picture}
