"""Input planes of detectors: their names, meanings and scales, computed from the signals of a finger."""

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
    ("firm", "firmness", 1, "pressed at three times its level (mean of 200 ms), or at five times"),
    ("drawn_right", "drawn_x", 1, "shear of the taxel or of all grows to the right, more than the pressing explains"),
    ("drawn_left", "drawn_x", -1, "the same to the left"),
    ("drawn_down", "drawn_y", 1, "the same downwards"),
    ("drawn_up", "drawn_y", -1, "the same upwards"),
    ("full", "share", 1, "shear over pressing is at least 0.9 of that at the rim of the contact"),
    ("stuck", "share", -1, "shear over pressing is at most 0.82 of that at the rim: the taxel sticks"),
)
"""Logic planes: name, source plane of the comparator, its factor, and the meaning of black."""
CODE = {
    "right": "shear points right (+x)", "left": "shear points left", "down": "shear points down (+y)",
    "up": "shear points up", "touch": "pressed",
}  # fmt: skip
WHOLE = {
    "loaded": "the total load is above its noise", "rising": "the load rises (25 % above its mean of 100 ms)",
    "falling": "the load falls (1.5 % of the held load within about 10 ms)",
    "dropping": "the load drops (4 % of the held load within about 10 ms): the finger opens",
    "loosened": "the load stays below 0.3 of the held load as long as it took to fall from half of it, or below 0.08",
    "unsteady": "the load differs by 3 % from its mean of 100 ms",
    "settled": "the load of a contact is within 0.05 of the held load (off above 0.2): no grip that closes or opens",
    "yielding": "the pull grows at less than 0.25 of its fastest of the last 0.5 s",
    "sticking": "sticking taxels bear more than 15 % of the load",
    "turning": "torque of the shear about the centre of pressure is clockwise, more than the pressing explains",
    "turning_back": "the same anticlockwise",
    "balanced": "neither turning nor turning back; force taxels only",
    "sheared": "shear changes by more than about half of the change of the pressing",
    "outweighs": "as `sheared`, and the change of shear is above its noise",
    "driven": "the total shear changes (0.4 % of the load, or 6 sigma, within about 0.2 s)",
    "travelling": "the located load moves over the skin: 50 um, or 6 sigma, within 0.25 s",
}  # fmt: skip
"""Uniform logic planes."""
GREY = {
    "shear_x": "shear over the levels of the taxel: 1/6 off, 1/4 on, 1 at four times on",
    "shear_y": "the same", "pressing": "the same of the normal component, positive when pressed",
    "drawn_x": "unexplained change of shear, mean of 10 ms minus mean of 200 ms, in the same scale",
    "drawn_y": "the same",
    "share": "share of the shear over share of the pressing: 1/4 from 0.9 on, -1/4 from 0.82 down, 0 unknown",
    "firmness": "mean of 200 ms (80 if unsteady) over three times the levels of pressing, or of 10 ms over five",
    "shear_x_full": "shear over full scale (10 N, strain 0.1 or 200 kPa), independent of the levels",
    "shear_y_full": "the same", "normal_full": "the same of the normal component, positive when pressed",
    "change_x": "change of shear_x since the last frame, in its scale", "change_y": "the same of shear_y",
    "change_n": "the same of pressing",
    "load_x": "x of the load over half the width of the array, in all cells; 0 without a load",
    "load_y": "y of the load over half the height",
    "load_q": "tangential load along x over full scale (10 N), in all cells", "load_r": "the same along y",
    "load_f": "normal load over full scale, in all cells",
}  # fmt: skip
"""Analog planes."""
LATE = ("yielding", "drawn")
"""Sources of a measured delay: the plane by its noise, the drawn shear by its bend."""
NAMES = (*CODE, *(name for name, *_ in CELLS), *WHOLE, "usable", *GREY)
FULL_LOAD = 10.0
"""[N] Load at which load_q, load_r and load_f are 1."""


def meanings() -> dict[str, str]:
    """Return the meaning of every plane by name."""
    cells = {name: what for name, _, _, what in CELLS}
    return {**CODE, **cells, **WHOLE, "usable": "valid, neither noisy nor dead", **GREY}


@dataclass
class Moment:
    """The inputs from which the analog planes of one frame are computed."""

    frame: Frame
    quantity: Quantity
    signals: Signals
    before: Floats
    load: Load | None
    half: tuple[float, float]
    origin: tuple[float, float]


class PlanePool:
    """The planes of one finger: logic planes are renewed when they change, analog planes when a detector reads them.

    ``version`` counts changes of the logic planes, which have the ``shape`` (rows, cols).
    """

    def __init__(self, machine: UniversalMachine, shape: tuple[int, int]) -> None:
        self.version = 0
        self.shape = shape
        self._cells = Switches(machine, shape, [PLANES.index(plane) for _, plane, _, _ in CELLS], [c[2] for c in CELLS])
        self._whole = Switches(machine, (1, len(LEVELS)), [0], [1.0])
        self._black, self._white = np.ones(shape), -np.ones(shape)
        self._logic: dict[str, Floats] = dict.fromkeys((*CODE, *WHOLE, *(c[0] for c in CELLS)), self._white)
        self._logic["usable"] = self._black
        self._cells_of = dict[str, bytes]()  # bytes of the non-uniform planes, to detect changes
        self._names = [name for name, *_ in CELLS]
        self._moment: Moment | None = None

    def set_logic(self, name: str, black: Flags | bool) -> None:
        """Set a logic plane (rows, cols), or all of its cells by one truth value."""
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
        """Whether a uniform plane is black; a plane never set is white."""
        plane = self._logic.get(name)
        return plane is self._black

    def late(self, name: str | None, since: float) -> float | None:
        """Return the delay [s], measured by one of `LATE`, of a plane that came on at ``since``; None if unknown."""
        if name is None or self._moment is None:
            return None
        signals = self._moment.signals
        return signals.late if name == "yielding" else max(since - signals.drawn_since(since), 0.0)

    def is_logic(self, name: str) -> bool:
        """Whether a plane is a logic plane."""
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
