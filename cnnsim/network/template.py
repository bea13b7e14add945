"""Template: the weights A, B and z of a cell's neighbourhood, and terms."""

from collections.abc import Iterable
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike

from cnnsim.network.term import Term
from cnnsim.network.weights import (
    MAX_RADIUS,
    Tap,
    all_taps,
    checked_number,
    checked_weights,
    matrix_text,
    reach,
    taps_of,
)
from cnnsim.support import Floats, InputError
from cnnsim.support.keywords import spelled

__all__ = ["MAX_RADIUS", "Tap", "Template", "all_taps"]


@dataclass(frozen=True, eq=False, repr=False)
class Template:
    """A template: dx/dt = -x + A*y + B*u + z + ``terms``.

    ``A`` (feedback) and ``B`` (control) are odd square matrices, up to 11 x 11, not necessarily of one size; ``z`` is
    the bias. ``*`` is a correlation: entry (k, l) weighs the neighbour at offset (k, l), the top row is the northern
    neighbours. Chua and Yang, "Cellular neural networks: theory", IEEE Trans. CAS 35 (1988) 1257. A template without
    terms is linear and the same in every cell; `cnnsim.network.term` describes terms.

    Raises:
        InputError: a matrix that is not square, of even side, too large, or with an entry that is not finite.
    """

    A: Floats
    B: Floats
    z: float = 0.0
    name: str = "unnamed"
    terms: tuple[Term, ...] = ()

    @spelled()
    def __init__(
        self, A: ArrayLike, B: ArrayLike = 0.0, z: float = 0.0, name: str = "unnamed", terms: Iterable[Term] = ()
    ) -> None:
        owner = f"template {name!r}"
        object.__setattr__(self, "name", name)
        object.__setattr__(self, "A", checked_weights(owner, "A", A))
        object.__setattr__(self, "B", checked_weights(owner, "B", B))
        object.__setattr__(self, "z", checked_number(owner, "z", z))
        terms = tuple(terms) if isinstance(terms, Iterable) else (terms,)
        object.__setattr__(self, "terms", terms)
        if not all(isinstance(term, Term) for term in self.terms):
            raise InputError(f"{owner}: terms are {self.terms!r}; a list of Term wanted")

    @cached_property
    def feedback_taps(self) -> tuple[Tap, ...]:
        """The non-zero entries of A, row by row."""
        return taps_of(self.A)

    @cached_property
    def control_taps(self) -> tuple[Tap, ...]:
        """The non-zero entries of B, row by row."""
        return taps_of(self.B)

    @cached_property
    def control_terms(self) -> tuple[Term, ...]:
        """The terms of the present input alone, which are constant like B*u."""
        return tuple(term for term in self.terms if term.control)

    @cached_property
    def feedback_terms(self) -> tuple[Term, ...]:
        """All other terms, which need the general time loop."""
        return tuple(term for term in self.terms if not term.control)

    @property
    def linear(self) -> bool:
        """Whether the template has no terms."""
        return not self.terms

    @property
    def reads_input(self) -> bool:
        """Whether B or a term reads u."""
        return bool(self.control_taps) or any("u" in term.quantities for term in self.terms)

    @property
    def self_feedback(self) -> float:
        """a, the centre of A."""
        r = self.A.shape[0] // 2
        return float(self.A[r, r])

    @property
    def uncoupled(self) -> bool:
        """Whether no cell depends on the output or state of another cell."""
        return all(tap.k == tap.l == 0 for tap in self.feedback_taps) and not any(t.couples for t in self.terms)

    @property
    def symmetric(self) -> bool:
        """Whether A(k, l) = A(-k, -l): then every transient settles (Chua and Yang 1988, theorem 3)."""
        return bool(np.array_equal(self.A, self.A[::-1, ::-1]))

    @property
    def isotropic(self) -> bool:
        """Whether A is invariant under quarter turns and transposition."""
        return np.array_equal(self.A, np.rot90(self.A)) and np.array_equal(self.A, self.A.T)

    @property
    def radius(self) -> int:
        """The largest radius of a non-zero entry of A, B and the terms."""
        taps = (*self.feedback_taps, *self.control_taps)
        return max(reach((tap.k, tap.l) for tap in taps), *(term.radius for term in self.terms), 0)

    def __repr__(self) -> str:
        matrices = f"A={matrix_text(self.A)}, B={matrix_text(self.B)}, z={self.z:g}"
        return f"Template({self.name!r}, {matrices}{self.terms_words})"

    @property
    def terms_words(self) -> str:
        """ ", 2 terms" for texts about the template; empty without terms."""
        count = len(self.terms)
        return f", {count} term{'s' * (count != 1)}" if count else ""

    def _repr_html_(self) -> str:
        from cnnsim.plot.html import facts, heading, matrices

        terms = {f"term {number}": term for number, term in enumerate(self.terms)}
        numbers = matrices({"A": self.A, "B": self.B, "z": np.array([[self.z]])})
        return heading("Template", self.name) + numbers + (facts(terms) if terms else "")

    def _repr_png_(self) -> bytes:
        from cnnsim import plot

        return plot.to_png(lambda axes: plot.template(self, axes), (6.0, 3.2))

    def state_bound(self, bias: float = 0.0) -> float:
        """Return |z| + |bias| + sum|A| + sum|B| + bounds of the terms: it bounds |x| if it bounds |x(0)|, |u| <= 1.

        Chua and Yang 1988, theorem 1. Terms are bounded for |x| <= 1.
        """
        linear = float(np.abs(self.A).sum() + np.abs(self.B).sum())
        return abs(self.z) + abs(bias) + linear + sum(term.bound for term in self.terms)
