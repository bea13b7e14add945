"""Integration schemes: explicit Runge-Kutta tables that check their own order. Add new ones to `SCHEMES`."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from cnnsim.support import Array, Floats
from cnnsim.support.errors import not_known


@dataclass(frozen=True)
class Scheme:
    """An explicit Runge-Kutta table: k_i = f(x + h sum_j a_ij k_j), x <- x + h sum_i b_i k_i.

    ``exponential`` replaces h by 1 - exp(-h): with one stage that is exponential Euler (ETD1), exact while the outputs
    stay, since the leak -x is the whole linear part. The declared ``order`` is checked against the order conditions
    (Hairer, Norsett, Wanner, "Solving Ordinary Differential Equations I", table II.2.1) when the table is made; the
    characteristic's kinks bring any fixed-step scheme down to order 2 where a cell saturates.
    """

    name: str
    a: tuple[tuple[float, ...], ...]
    b: tuple[float, ...]
    order: int
    exponential: bool = False

    def __post_init__(self) -> None:
        if len(self.a) != len(self.b) or any(len(row) != i for i, row in enumerate(self.a)):
            raise ValueError(f"{self.name}: row i of an explicit table has i entries, one row a weight")
        for order, (value, wanted) in enumerate(zip(self._conditions(), _CONDITIONS, strict=True), start=1):
            holds = all(abs(v - w) < 1e-12 for v, w in zip(value, wanted, strict=True))
            if holds != (order <= self.order):
                raise ValueError(f"{self.name}: declares order {self.order}, but order {order} holds: {holds}")
            if not holds:
                break

    def _conditions(self) -> tuple[tuple[float, ...], ...]:
        a, b = self.matrix, np.array(self.b)
        c = a.sum(axis=1)
        return (
            (float(b.sum()),),
            (float(b @ c),),
            (float(b @ c**2), float(b @ a @ c)),
            (float(b @ c**3), float((b * c) @ a @ c), float(b @ a @ c**2), float(b @ a @ a @ c)),
        )

    @cached_property
    def matrix(self) -> Floats:
        """The table a as a square matrix."""
        square = np.zeros((len(self.b), len(self.b)))
        for i, row in enumerate(self.a):
            square[i, :i] = row
        return square

    @property
    def keeps_rates(self) -> bool:
        """Whether a stage reads the rate of a stage before the previous one."""
        return any(any(row[:-1]) for row in self.a)

    @cached_property
    def real_limit(self) -> float:
        """The largest h |lambda| for which a real decaying mode stays bounded: |R(-h lambda)| <= 1."""
        size = np.linspace(0, 10, 100_001)[1:]
        stages = np.zeros((len(self.b), size.size))
        for i in range(len(self.b)):
            stages[i] = -size * (1 + self.matrix[i] @ stages)
        bounded = np.abs(1 + np.array(self.b) @ stages) <= 1 + 1e-9
        return float(size[np.argmin(bounded) - 1])

    def gain_limit(self, modes: Array) -> float:
        """Return the least gain g at which one of the decaying, oscillating modes grows: |R(g mode)| > 1.

        The distance at which a ray leaves the region |R(z)| <= 1 depends only on its angle. A table over the angle
        selects the modes with the smallest gains; for these the distance is computed.
        """
        angles, sizes = self._rays
        first = np.argsort(np.interp(np.angle(modes), angles, sizes) / np.abs(modes))[:8]
        return min((self._ray(float(np.angle(mode))) / float(abs(mode)) for mode in modes[first]), default=np.inf)

    @cached_property
    def _rays(self) -> tuple[Floats, Floats]:
        angles = np.linspace(np.pi / 2 + 1e-6, np.pi, 181)  # on the axis itself nothing decays
        return angles, np.minimum([self._ray(angle) for angle in angles], 1e3)

    def _ray(self, angle: float) -> float:
        """Return |z| where a ray leaves |R(z)| <= 1: R(z) = 1 + sum over j of b a^(j-1) 1 z^j, so |R|^2 - 1 along it is
        a polynomial in |z|, which is divided by |z|.
        """
        powers, ones = [1.0], np.ones(len(self.b))
        for _ in self.b:
            powers.append(float(np.array(self.b) @ ones))
            ones = self.matrix @ ones
        along = np.array(powers) * np.exp(1j * angle * np.arange(len(powers)))
        roots = np.roots(np.convolve(along, along.conj()).real[:0:-1])
        crossings = roots.real[(np.abs(roots.imag) < 1e-9 * (1 + np.abs(roots))) & (roots.real > 0)]
        return float(crossings.min(initial=np.inf))

    def gain(self, h: float) -> float:
        """Return the step used in the table: h, or 1 - exp(-h) for an exponential scheme."""
        return float(-np.expm1(-h)) if self.exponential else h


_CONDITIONS = ((1.0,), (1 / 2,), (1 / 3, 1 / 6), (1 / 4, 1 / 8, 1 / 12, 1 / 24))

EULER = Scheme("euler", ((),), (1.0,), order=1)
EXPONENTIAL_EULER = Scheme("exponential-euler", ((),), (1.0,), order=1, exponential=True)
HEUN = Scheme("heun", ((), (1.0,)), (1 / 2, 1 / 2), order=2)
RK4 = Scheme("rk4", ((), (1 / 2,), (0.0, 1 / 2), (0.0, 0.0, 1.0)), (1 / 6, 1 / 3, 1 / 3, 1 / 6), order=4)

SCHEMES = {scheme.name: scheme for scheme in (EULER, EXPONENTIAL_EULER, HEUN, RK4)}
ADAPTIVE = "adaptive"
"""Step control by scipy (DOP853) instead of a table, for reference solutions on the reference backend."""


def find_scheme(name: str) -> Scheme:
    """Return the fixed-step scheme called ``name``.

    Raises:
        InputError: there is none.
    """
    if name not in SCHEMES:
        raise not_known("scheme", name, (*SCHEMES, ADAPTIVE))
    return SCHEMES[name]
