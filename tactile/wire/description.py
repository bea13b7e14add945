"""Array description: the boards of a device, the mapping of their readings to frames, and the wire format."""

from dataclasses import dataclass, field

from cnnsim.support import Floats, InputError, Integers
from tactile.calibration.gains import Gains
from tactile.core.frame import TaxelArray
from tactile.thresholds.choices import ThresholdChoices
from tactile.wire.base import Options
from tactile.wire.registry import Format


@dataclass(frozen=True)
class Board:
    """Mapping of the readings of one board to the frames of a finger.

    ``turn`` (3, 3) maps device axes to (shear_x, shear_y, normal), (3, 1) if the board measures the normal alone;
    ``gains`` is None if the unit of the wire is that of the quantity, or if the board is uncalibrated; ``cells`` (rows,
    cols) chip numbers, -1 for none.
    """

    array: TaxelArray
    turn: Floats
    gains: Gains | None
    cells: Integers

    @property
    def chips(self) -> int:
        """Number of taxels of this board on the wire."""
        return int((self.cells >= 0).sum())


@dataclass(frozen=True)
class Description:
    """Description of a device; ``text`` is the file it was read from, which recordings keep.

    ``thresholds``: defaults of the pipeline where the user chooses none.
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
        """Arrays of the fingers."""
        return tuple(board.array for board in self.boards)

    @property
    def uncalibrated(self) -> tuple[str, ...]:
        """Names of the fingers whose readings are in the unit of the wire."""
        raw = not self.wire.calibrated(self.options)
        return tuple(board.array.name for board in self.boards if raw and board.gains is None)

    def check_calibrated(self) -> None:
        """Refuse readings whose unit is no quantity.

        Raises:
            InputError: a board in microtesla without gains.
        """
        for name in self.uncalibrated:
            raise InputError(
                f"finger {name!r}: {self.wire.name} sends microtesla; gains = [shear, normal] per uT"
                " wanted in the array description (record and convert work without them)"
            )
