"""Template: the numbers A, B, z that say how a cell listens to its neighbours."""

from dataclasses import dataclass, field
from functools import cached_property
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from cnnsim.errors import InputError

MAX_RADIUS = 5


class Tap(NamedTuple):
    """One entry of a template that is not zero: the neighbour at (row + k, col + l) counts ``weight`` times."""

    k: int
    l: int
    weight: float


@dataclass(frozen=True, eq=False)
class Template:
    """A linear space-invariant template: dx/dt = -x + A*y + B*u + z.

    ``A`` (feedback) and ``B`` (control) are odd square matrices, up to 11 x 11, not necessarily of one size; ``z`` is
    the bias. ``*`` is a correlation: entry (k, l) weighs the neighbour at offset (k, l), the top row is the northern
    neighbours. Chua and Yang, "Cellular neural networks: theory", IEEE Trans. CAS 35 (1988) 1257.

    Raises:
        InputError: a matrix that is not square, of even side, too large, or with an entry that is not finite.
    """

    A: NDArray[np.float64] = field(repr=False)
    B: NDArray[np.float64] = field(repr=False)
    z: float = 0.0
    name: str = "unnamed"

    def __init__(self, A: ArrayLike, B: ArrayLike = 0.0, z: float = 0.0, name: str = "unnamed") -> None:
        object.__setattr__(self, "name", name)
        object.__setattr__(self, "A", self._matrix("A", A))
        object.__setattr__(self, "B", self._matrix("B", B))
        if isinstance(z, bool) or not isinstance(z, int | float | np.number) or not np.isfinite(z):
            raise InputError(f"template {name!r}: z is {z!r}, a finite number wanted")
        object.__setattr__(self, "z", float(z))

    def _matrix(self, which: str, entries: ArrayLike) -> NDArray[np.float64]:
        try:
            matrix = np.array(entries, dtype=np.float64)
        except (TypeError, ValueError) as error:
            raise InputError(
                f"template {self.name!r}: {which} is no rectangular matrix of numbers: {entries!r}"
            ) from error
        if matrix.ndim == 0:
            matrix = matrix.reshape(1, 1)
        if matrix.ndim != 2 or matrix.shape[0] != matrix.shape[1] or matrix.shape[0] % 2 == 0:
            shape = " x ".join(map(str, matrix.shape))
            raise InputError(f"template {self.name!r}: {which} is {shape}, an odd square (3 x 3, 5 x 5, ...) wanted")
        if matrix.shape[0] > 2 * MAX_RADIUS + 1:
            raise InputError(
                f"template {self.name!r}: {which} has radius {matrix.shape[0] // 2}, at most {MAX_RADIUS} wanted"
            )
        if not np.isfinite(matrix).all():
            row, col = np.argwhere(~np.isfinite(matrix))[0]
            raise InputError(
                f"template {self.name!r}: {which} holds {matrix[row, col]} in row {row + 1}, column {col + 1}; "
                "finite numbers wanted"
            )
        matrix.flags.writeable = False
        return matrix

    @cached_property
    def feedback_taps(self) -> tuple[Tap, ...]:
        """The entries of A that are not zero, row by row."""
        return _taps(self.A)

    @cached_property
    def control_taps(self) -> tuple[Tap, ...]:
        """The entries of B that are not zero, row by row."""
        return _taps(self.B)

    @property
    def self_feedback(self) -> float:
        """a, the centre of A."""
        r = self.A.shape[0] // 2
        return float(self.A[r, r])

    @property
    def uncoupled(self) -> bool:
        """True if A feeds no neighbour back: every cell is on its own once B*u + z is known."""
        return all(tap.k == tap.l == 0 for tap in self.feedback_taps)

    @property
    def symmetric(self) -> bool:
        """True if A(k, l) = A(-k, -l): then every transient settles (Chua and Yang 1988, theorem 3)."""
        return bool(np.array_equal(self.A, self.A[::-1, ::-1]))

    @property
    def isotropic(self) -> bool:
        """True if A looks the same after a quarter turn and in a mirror."""
        return np.array_equal(self.A, np.rot90(self.A)) and np.array_equal(self.A, self.A.T)

    @property
    def radius(self) -> int:
        """The larger radius of A and B, zero rims left out."""
        taps = (*self.feedback_taps, *self.control_taps)
        return max((max(abs(tap.k), abs(tap.l)) for tap in taps), default=0)

    def state_bound(self, bias: float = 0.0) -> float:
        """Return |z| + |bias| + sum|A| + sum|B|: |x| stays within it if |x(0)| does and |u| <= 1.

        Chua and Yang 1988, theorem 1.
        """
        return abs(self.z) + abs(bias) + float(np.abs(self.A).sum() + np.abs(self.B).sum())


def all_taps(matrix: NDArray[np.float64]) -> tuple[Tap, ...]:
    """Return every entry of a template matrix as a tap, row by row, zeros included."""
    r = matrix.shape[0] // 2
    return tuple(Tap(int(k) - r, int(l) - r, float(matrix[k, l])) for k, l in np.ndindex(matrix.shape))


def _taps(matrix: NDArray[np.float64]) -> tuple[Tap, ...]:
    return tuple(tap for tap in all_taps(matrix) if tap.weight)
