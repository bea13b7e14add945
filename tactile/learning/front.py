"""Front end of learned detectors: the planes of a finger, and kept planes of what was black in this contact."""

from collections.abc import Sequence
from dataclasses import dataclass

from cnnsim.support import InputError
from cnnsim.support.errors import not_known
from tactile.events.planes import GREY, NAMES

TOUCH = "touch"
ONE_WAY = ("right", "left", "up", "down", "_x", "_y", "_q", "_r", "_full", "usable")
"""Endings of planes that are read on request alone: those of one direction or place, of a full scale, or of no load."""
KEPT = "_was"
"""Ending of a kept plane: black from the first time its plane is black until the taxel is no longer touched."""


@dataclass(frozen=True)
class Front:
    """Planes that a template reads: ``planes`` of the finger, and kept planes of those in ``kept``."""

    planes: tuple[str, ...]
    kept: tuple[str, ...]

    @property
    def names(self) -> tuple[str, ...]:
        """All planes, the kept ones last."""
        return (*self.planes, *(f"{name}{KEPT}" for name in self.kept))

    @property
    def inputs(self) -> list[str]:
        """Planes of the finger that are needed: the kept planes need their own and the touch."""
        return list(dict.fromkeys((*self.planes, *self.kept, TOUCH)))

    @property
    def steps(self) -> list[str]:
        """The steps of a program that renew the kept planes."""
        return [
            line for name in self.kept for line in (
                f'{{ logic = "or", of = ["{name}{KEPT}", "{name}"], to = "{name}{KEPT}" }},',
                f'{{ logic = "and", of = ["{name}{KEPT}", "{TOUCH}"], to = "{name}{KEPT}" }},',
            )
        ]  # fmt: skip

    def head(self, name: str, summary: str, outputs: Sequence[str], more: tuple[Sequence[str], ...]) -> str:
        """Return the declarations of a program; ``more``: further analog planes, logic planes and registers."""
        logic = {TOUCH, *self.kept}
        analog, black, wires = more
        planes = [one for one in self.inputs if one not in logic]
        keep = ", ".join(f"{one}{KEPT} = -1" for one in self.kept)
        return "\n".join([
            f'name    = "{name}"', f'summary = "{summary}"', f"lam     = {_list([*planes, *analog])}",
            f"llm     = {_list([*sorted(logic), *self.names[len(self.planes) :], *black])}",
            f"wire    = {_list(wires)}", f"inputs  = {_list(self.inputs)}", f"outputs = {_list(outputs)}",
            *([f"keep    = {{ {keep} }}"] if keep else []),
        ]) + "\n"  # fmt: skip

    def tap(self) -> str:
        """Return a program whose outputs are the planes of the finger, without the kept ones."""
        bare = Front(tuple(self.inputs), ())
        head = bare.head("tap", "Planes of the taxels.", self.inputs, ([], [], ["nothing"]))
        return head + 'step = [{ fill = 0, to = "nothing" }]\n'


def front_of(planes: Sequence[str] = ()) -> Front:
    """Return the front end that reads planes by name, by default all without a direction, and keeps logic planes.

    Raises:
        InputError: an unknown plane.
    """
    for name in planes:
        if name not in NAMES:
            raise not_known("plane", name, NAMES)
    chosen = tuple(dict.fromkeys(planes)) or tuple(name for name in NAMES if not name.endswith(ONE_WAY))
    if chosen == (TOUCH,):
        raise InputError(f"planes {TOUCH} alone; others wanted, because the detector looks at touched taxels")
    return Front(chosen, tuple(name for name in chosen if name not in (*GREY, TOUCH)))


def _list(names: Sequence[str]) -> str:
    return "[" + ", ".join(f'"{name}"' for name in names) + "]"
