"""Planes that detectors are given: what each means, in which scale, and how it is made of a finger's signals."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from cnnsim.program.machine import UniversalMachine
from cnnsim.support import Flags, Floats
from tactile.core.frame import Frame, Quantity
from tactile.events.comparators import Switches
from tactile.events.signals.names import LEVELS, PLANES
from tactile.events.signals.signals import Signals
from tactile.inverse.load import Load

FULL_SCALE: dict[Quantity, float] = {"force": 10.0, "strain": 0.1, "stress": 2e5}
"""Reading [N, 1, Pa] of one taxel that is 1 in the planes in units of full scale."""
CELLS: tuple[tuple[str, str, float, str], ...] = (
    ("firm", "firmness", 1, "pressed at three times its level for a while, or at five times"),
    ("drawn_right", "drawn_x", 1, "shear grows to the right, more than the pressing explains: its own or that of all"),
    ("drawn_left", "drawn_x", -1, "the same to the left"),
    ("drawn_down", "drawn_y", 1, "the same downwards"),
    ("drawn_up", "drawn_y", -1, "the same upwards"),
    ("full", "share", 1, "carries as much shear for its pressing as the rim of the contact (0.9): slides if all do"),
    ("stuck", "share", -1, "carries at most 0.82 of that: sticks"),
)
"""Logic planes: name, the analog plane that a comparator watches, times what, and the meaning where black."""
CODE = {
    "right": "shear points right (+x)", "left": "shear points left", "down": "shear points down (+y)",
    "up": "shear points up", "touch": "pressed",
}  # fmt: skip
WHOLE = {
    "loaded": "the whole load is above its noise", "rising": "the load rises (25 % above its mean of 100 ms)",
    "falling": "the load falls (1.5 % of the held load within about 10 ms)",
    "dropping": "the load drops (4 % of the held load within about 10 ms): the finger opens",
    "steep": "the fall is steep, at 0.6 of the steepest of late",
    "large": "the load is above 0.3 of the held one, until it is below 0.2",
    "unsteady": "the load is away from its mean of 100 ms (3 %)",
    "sheared": "shear changes by more than about half of what the pressing does",
    "yielding": "the pull grows no more, at less than 0.25 of its fastest of late",
    "sticking": "taxels that stick bear more than 15 % of the load",
    "turning": "the whole shear turns clockwise: more than the pressing explains, about its middle",
    "turning_back": "the same anticlockwise",
    "balanced": "neither: the shear makes next to no such torque; of forces alone",
    "outweighs": "as `sheared`, and shear changes by more than noise does",
    "driven": "the whole shear changes (0.4 % of the load, or 6 sigma, within about 0.2 s)",
    "travelling": "the located load travels over the skin: 50 um, or 6 sigma, within 0.25 s",
}  # fmt: skip
"""Logic planes that are black or white as a whole."""
GREY = {
    "shear_x": "shear over the taxel's own levels: 1/6 off, 1/4 on, 1 at four times on",
    "shear_y": "the same", "pressing": "the same of the normal component, positive when pressed",
    "drawn_x": "unexplained change of shear, mean of 10 ms less that of 200 ms, in the same scale",
    "drawn_y": "the same",
    "share": "share of the shear over share of the pressing: 1/4 from 0.9 on, -1/4 from 0.82 down, 0 unknown",
    "firmness": "mean of 200 ms (80 if unsteady) over three times the levels of pressing, or of 10 ms over five",
    "shear_x_full": "shear over full scale: 10 N, strain 0.1 or 200 kPa a taxel, whatever the levels",
    "shear_y_full": "the same", "normal_full": "the same of the normal component, positive when pressed",
    "change_x": "change of shear_x since the last frame, in the scale of shear_x", "change_y": "the same of shear_y",
    "change_n": "the same of pressing",
    "load_x": "place of the load over half the width of the array, in all cells; 0 without a load",
    "load_y": "the same, over half its height",
    "load_q": "tangential load along x over full scale (10 N), in all cells", "load_r": "the same along y",
    "load_f": "normal load over full scale, in all cells",
}  # fmt: skip
"""Analog planes."""
LATE = ("yielding", "drawn")
"""What knows when it began: the plane by its noise, what is drawn by the bend of the shear."""
NAMES = (*CODE, *(name for name, *_ in CELLS), *WHOLE, "usable", *GREY)
FULL_LOAD = 10.0
"""[N] of a load that is 1."""


def meanings() -> dict[str, str]:
    """Return what every plane means, by name."""
    cells = {name: what for name, _, _, what in CELLS}
    return {**CODE, **cells, **WHOLE, "usable": "reads, and is neither noisy nor dead", **GREY}


@dataclass
class Moment:
    """What the grey planes of one frame are made of."""

    frame: Frame
    quantity: Quantity
    signals: Signals
    before: Floats
    load: Load | None
    half: tuple[float, float]
    origin: tuple[float, float]


class PlanePool:
    """The planes of one finger: logic ones are made when they change, grey ones when a detector asks.

    ``version`` counts the changes of logic planes, which are of ``shape`` (rows, cols).
    """

    def __init__(self, machine: UniversalMachine, shape: tuple[int, int]) -> None:
        self.version = 0
        self.shape = shape
        self._cells = Switches(machine, shape, [PLANES.index(plane) for _, plane, _, _ in CELLS], [c[2] for c in CELLS])
        self._whole = Switches(machine, (1, len(LEVELS)), [0], [1.0])
        self._black, self._white = np.ones(shape), -np.ones(shape)
        self._logic: dict[str, Floats] = dict.fromkeys((*CODE, *WHOLE, *(c[0] for c in CELLS)), self._white)
        self._logic["usable"] = self._black
        self._cells_of = dict[str, bytes]()  # what planes that differ from cell to cell were made of
        self._names = [name for name, *_ in CELLS]
        self._moment: Moment | None = None

    def set_logic(self, name: str, black: Flags | bool) -> None:
        """Renew one logic plane (rows, cols), or all of it by one truth value."""
        if isinstance(black, np.ndarray):
            cells = black.tobytes()
            if self._cells_of.get(name) == cells:
                return
            self._cells_of[name], plane = cells, np.where(black, 1.0, -1.0)
        else:
            plane = self._black if black else self._white
            if self._logic.get(name) is plane:
                return
            self._cells_of.pop(name, None)
        self._logic[name] = plane
        self.version += 1

    def update(self, moment: Moment) -> None:
        """Take the signals of a frame."""
        self._moment = moment
        signals = moment.signals
        if self._cells.update(signals.planes):
            for name, on in zip(self._names, self._cells.on, strict=True):
                self.set_logic(name, on)
        if self._whole.update(signals.levels[None, None]):
            for name, black in zip(LEVELS, self._whole.on[0, 0].tolist(), strict=True):
                self.set_logic(name, black)

    def black(self, name: str) -> bool:
        """Whether a plane that is black or white as a whole is black; one that nobody has made yet is white."""
        plane = self._logic.get(name)
        return plane is self._black

    def late(self, name: str | None, since: float) -> float | None:
        """Return what comes late [s] of what was on ``since`` then, as one of `LATE` knows; None if it does not."""
        if name is None or self._moment is None:
            return None
        signals = self._moment.signals
        return signals.late if name == "yielding" else max(since - signals.drawn_since(since), 0.0)

    def is_logic(self, name: str) -> bool:
        """Whether a plane is black and white, and so changes seldom."""
        return name in self._logic

    def __getitem__(self, name: str) -> Floats:
        if name in self._logic:
            return self._logic[name]
        assert self._moment is not None
        return np.clip(_GREY[name](self._moment), -1, 1)


def _full(axis: int) -> Callable[[Moment], Floats]:
    def plane(now: Moment) -> Floats:
        inward = -1.0 if axis == 2 and now.quantity != "force" else 1.0
        values = np.where(now.frame.valid, now.frame.values[..., axis], 0.0)
        return inward * values / FULL_SCALE[now.quantity]

    return plane


def _load(name: str) -> Callable[[Moment], Floats]:
    def plane(now: Moment) -> Floats:
        value = getattr(now.load, name) if now.load is not None else 0.0
        if name in "xy":
            axis = "xy".index(name)
            value = (value - now.origin[axis]) / now.half[axis]
        else:
            value /= FULL_LOAD
        return np.full(now.frame.valid.shape, value if np.isfinite(value) else 0.0)

    return plane


CHANGES = ("change_x", "change_y", "change_n")

_GREY: dict[str, Callable[[Moment], Floats]] = {
    **{name: (lambda now, n=n: now.signals.planes[n]) for n, name in enumerate(PLANES)},  # type: ignore[misc]
    **{name: (lambda now, n=n: now.signals.planes[n] - now.before[n]) for n, name in enumerate(CHANGES)},  # type: ignore[misc]
    "shear_x_full": _full(0), "shear_y_full": _full(1), "normal_full": _full(2),
    "load_x": _load("x"), "load_y": _load("y"), "load_q": _load("Q"), "load_r": _load("R"), "load_f": _load("F"),
}  # fmt: skip
