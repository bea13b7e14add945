"""Taxel arrays and their frames: shapes, units, axes and signs (CONVENTIONS.md)."""

from dataclasses import dataclass
from numbers import Real
from typing import Literal, get_args

import numpy as np

from cnnsim.support import Flags, Floats, InputError
from cnnsim.support.files import check_name
from cnnsim.support.keywords import spelled_class
from cnnsim.support.limits import READING, TAXELS, check_most
from cnnsim.support.values import is_whole

Quantity = Literal["strain", "stress", "force"]
"""Measured quantity: strain (u_xz, u_yz, u_zz), stress [Pa] of the same components, or force [N]."""

HAND = "hand"
"""Finger name of events of several fingers; no array may have it."""
FLAGS = {"slip_detection": 1, "reference_loaded": 2, "contact": 4}
"""Status flags of a device -> bit."""
MOST_FLAGS = 2**32 - 1
"""Largest value of the flags in recordings."""

SHEAR_X, SHEAR_Y, NORMAL = 0, 1, 2
"""The last axis of a frame."""


@spelled_class
@dataclass(frozen=True)
class TaxelArray:
    """A rectangular array of three-axial taxels under the cover of one finger.

    Arguments: ``rows``, ``cols``; ``pitch`` [m] between neighbours; ``depth`` [m] of the taxels below the surface of
    the cover (unused for force sensors); ``origin`` [m], the (x, y) of the centre of the array; ``thickness`` [m] of
    the cover over its rigid base, at least the depth: loads are then located on a layer of this thickness, or on a
    half-space if None; ``shear``: False for force taxels that measure the normal alone, whose shear is 0.

    Raises:
        InputError: a name of other characters than letters, digits, - and _, an empty or too large array, a
            pitch that is not positive, a negative depth, a thickness below the depth, an unknown quantity.
    """

    name: str
    rows: int
    cols: int
    pitch: float
    depth: float
    origin: tuple[float, float] = (0.0, 0.0)
    quantity: Quantity = "strain"
    thickness: float | None = None
    shear: bool = True

    def __post_init__(self) -> None:
        lengths = all(isinstance(one, Real) for one in (self.pitch, self.depth))
        if not (isinstance(self.name, str) and lengths and all(map(is_whole, (self.rows, self.cols)))):
            raise InputError(
                f"taxel array {self.name!r}: {self.rows!r} x {self.cols!r} taxels, pitch {self.pitch!r}, depth"
                f" {self.depth!r}; a text, two integers and two lengths [m] wanted"
            )
        check_name(self.name, "taxel array")
        if self.name == HAND:
            raise InputError("taxel array 'hand': the name of events of several fingers; another name wanted")
        if self.rows < 1 or self.cols < 1:
            raise InputError(f"taxel array {self.name!r}: {self.rows} x {self.cols} taxels, at least 1 x 1 wanted")
        check_most(self.rows * self.cols, TAXELS, f"taxel array {self.name!r}: {self.rows} x {self.cols} taxels")
        if not (np.isfinite(self.pitch) and self.pitch > 0):
            raise InputError(f"taxel array {self.name!r}: pitch {self.pitch} m, a positive length wanted")
        if not (np.isfinite(self.depth) and self.depth >= 0) or (self.depth == 0 and self.quantity != "force"):
            raise InputError(f"taxel array {self.name!r}: depth {self.depth} m, a positive length wanted")
        if self.thickness is not None and not (isinstance(self.thickness, Real) and self.thickness >= self.depth):
            raise InputError(
                f"taxel array {self.name!r}: a cover {self.thickness!r} m thick over taxels {self.depth} m deep; a"
                " thickness [m] of at least the depth wanted"
            )
        if self.quantity not in get_args(Quantity):
            wanted = ", ".join(get_args(Quantity))
            raise InputError(f"taxel array {self.name!r}: quantity {self.quantity!r}, one of {wanted} wanted")
        if not self.shear and self.quantity != "force":
            raise InputError(
                f'taxel array {self.name!r}: {self.quantity} of the normal alone; quantity "force" wanted, because'
                " loads are located from normal and shear"
            )
        self._take_origin()
        for name, kind in (("rows", int), ("cols", int), ("pitch", float), ("depth", float)):
            object.__setattr__(self, name, kind(getattr(self, name)))

    def _take_origin(self) -> None:
        try:
            x, y = map(float, self.origin)
            near = bool(np.isfinite([x, y]).all())
        except (TypeError, ValueError):
            near = False
        if not near or isinstance(self.origin, str):
            raise InputError(f"taxel array {self.name!r}: origin {self.origin!r}; its centre (x, y) [m] wanted")
        object.__setattr__(self, "origin", (x, y))

    @property
    def shape(self) -> tuple[int, int]:
        """(rows, cols)."""
        return self.rows, self.cols

    def positions(self) -> Floats:
        """(rows, cols, 2) taxel centres (x, y) [m]: x grows with the column, y with the row."""
        x = self.origin[0] + (np.arange(self.cols) - (self.cols - 1) / 2) * self.pitch
        y = self.origin[1] + (np.arange(self.rows) - (self.rows - 1) / 2) * self.pitch
        places = np.empty((self.rows, self.cols, 2))
        places[..., 0], places[..., 1] = x, y[:, None]
        return places


@dataclass(frozen=True)
class Frame:
    """One reading of the array of one finger.

    ``values`` (rows, cols, 3), last axis (shear_x, shear_y, normal) in the unit of the array's quantity; ``t`` [s] host
    time since the start of the stream; ``t_device`` [s] device clock (NaN without one); ``valid`` (rows, cols), False
    where a reading must not be used; ``flags``: status flags of the device (`FLAGS` added), which the pipeline ignores.
    """

    finger: int
    t: float
    sequence: int
    values: Floats
    valid: Flags
    t_device: float = float("nan")
    flags: int = 0

    @property
    def whole(self) -> bool:
        """Whether every taxel is valid."""
        found: bool | None = self.__dict__.get("_whole")
        if found is None:  # kept, without the lock that `cached_property` takes in each frame
            found = self.__dict__["_whole"] = bool(self.valid.all())
        return found

    @property
    def read(self) -> Flags:
        """(rows, cols), True where a taxel is valid and its reading is finite and within range."""
        values: Floats = self.values
        if np.vdot(values, values) < READING**2:  # then all are; NaN and infinity fail the comparison
            return self.valid
        return self.valid & (np.abs(values) <= READING).all(-1)

    def __repr__(self) -> str:
        rows, cols = self.valid.shape
        used = self.values[self.valid]
        extent = f"{used.min():.3g} to {used.max():.3g}" if used.size else "no readings"
        shape = f"{rows} x {cols}, {int(self.valid.sum())} valid"
        return f"Frame(finger={self.finger}, t={self.t:g}, sequence={self.sequence}, {shape}, {extent})"

    def __post_init__(self) -> None:
        if not isinstance(self.values, np.ndarray) or not isinstance(self.valid, np.ndarray):
            raise InputError(f"frame {self.sequence}: lists of values; arrays (rows, cols, 3) and (rows, cols) wanted")
        if self.values.ndim != 3 or self.values.shape[2] != 3:
            raise InputError(f"frame {self.sequence}: values of shape {self.values.shape}, (rows, cols, 3) wanted")
        if self.valid.shape != self.values.shape[:2]:
            raise InputError(
                f"frame {self.sequence}: validity of shape {self.valid.shape}, {self.values.shape[:2]} wanted"
            )
