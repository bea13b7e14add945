"""The global wire: what the whole array says at once about a black-and-white plane."""

from typing import Literal, get_args

from cnnsim.errors import InputError

Wire = Literal["any", "all", "count"]


def read_wire(wire: Wire, black: int, cells: int) -> int:
    """Return the wire's value: 1 or 0 for "any" and "all" black, the number of black cells for "count"."""
    return {"any": int(black > 0), "all": int(black == cells), "count": black}[wire]


def check_wire(name: str) -> Wire:
    """Return ``name`` as a wire.

    Raises:
        InputError: there is no such wire.
    """
    if name not in get_args(Wire):
        raise InputError(f"global wire {name!r}; known are {', '.join(get_args(Wire))}")
    return name  # type: ignore[return-value]  # just checked
