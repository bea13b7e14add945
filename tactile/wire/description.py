"""Description of what is on the other end of a cable: the boards, how their readings become frames, the wire format."""

from dataclasses import dataclass, field

from cnnsim.support import Floats, InputError, Integers
from tactile.calibration.gains import Gains
from tactile.core.frame import TaxelArray
from tactile.thresholds.choices import ThresholdChoices
from tactile.wire.base import Options
from tactile.wire.registry import Format


@dataclass(frozen=True)
class Board:
    """How one board's readings become a finger's frame.

    ``turn`` (3, 3) takes device axes to (shear_x, shear_y, normal); ``gains`` None where the wire's unit is already
    the quantity's, or where nobody has calibrated it; ``cells`` (rows, cols) chip numbers, -1 for none.
    """

    array: TaxelArray
    turn: Floats
    gains: Gains | None
    cells: Integers

    @property
    def chips(self) -> int:
        """Number of taxels that the wire carries for this board."""
        return int((self.cells >= 0).sum())


@dataclass(frozen=True)
class Description:
    """What is on the other end of the cable; ``text`` is the file it was read from, kept in recordings.

    ``thresholds``: what the pipeline is to use where its user chooses nothing else.
    """

    title: str
    wire: Format
    baudrate: int
    modulus: float | None
    options: Options
    boards: tuple[Board, ...]
    text: str
    thresholds: ThresholdChoices = field(default_factory=ThresholdChoices)

    def __repr__(self) -> str:
        fingers = ", ".join(f"{array.name} {array.rows} x {array.cols}" for array in self.arrays)
        return f"Description({self.title!r}, {self.wire.name}, {fingers})"

    @property
    def arrays(self) -> tuple[TaxelArray, ...]:
        """The fingers' arrays."""
        return tuple(board.array for board in self.boards)

    @property
    def uncalibrated(self) -> tuple[str, ...]:
        """Names of the fingers whose readings are in the unit of the wire, which is no quantity's."""
        raw = not self.wire.calibrated(self.options)
        return tuple(board.array.name for board in self.boards if raw and board.gains is None)

    def check_calibrated(self) -> None:
        """Refuse to interpret readings whose unit is no quantity.

        Raises:
            InputError: a board in microtesla without gains.
        """
        for name in self.uncalibrated:
            raise InputError(
                f"finger {name!r}: {self.wire.name} sends microtesla; gains = [shear, normal] per uT"
                " wanted in the array description (record and convert work without them)"
            )
