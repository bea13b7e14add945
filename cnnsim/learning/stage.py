"""Stage: a template to be trained, its free entries, and the map from free numbers to its weights."""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any, Literal, get_args

import numpy as np

from cnnsim.learning.adjoint import weights_of, with_weights
from cnnsim.network import Template, Term, layered
from cnnsim.network.weights import MAX_RADIUS, checked_number, checked_weights
from cnnsim.support import Array, Flags, Floats, InputError
from cnnsim.support.errors import not_known, shown
from cnnsim.support.keywords import spelled_class
from cnnsim.support.values import is_number

Symmetry = Literal["all", "mirror", "none"]
"""Entries that are one number: in all eight directions, left and right, or none."""
Source = Literal["picture", "given"]
"""A plane of a stage: the picture, which is the output of the stage before, if there is one; or the second picture."""
FREE = "free"


@spelled_class
@dataclass(frozen=True)
class Stage:
    """A template to be trained, one of a sequence.

    ``A``, ``B`` and ``z``: numbers are held, "free" entries are trained; "free" for a matrix is a whole one of
    ``radius``. ``terms`` are trained as well: their weights, from their own values. ``input`` and ``initial_state``: a
    `Source`, or a number. ``duration`` [time constants] of a run in training.

    Raises:
        InputError: A or B is no odd square of numbers and "free", an unknown word, a number out of range.
    """

    A: Any = FREE
    B: Any = FREE
    z: Any = FREE
    radius: int = 1
    symmetry: Symmetry = "none"
    input: Source | float = "picture"
    initial_state: Source | float = "picture"
    duration: float = 10.0
    terms: tuple[Term, ...] = ()

    def __post_init__(self) -> None:
        if self.symmetry not in get_args(Symmetry):
            raise not_known("symmetry", self.symmetry, get_args(Symmetry))
        for name in ("input", "initial_state"):
            value = getattr(self, name)
            if not (is_number(value) and abs(value) <= 1) and value not in get_args(Source):
                raise InputError(f"{name} {value!r}; {', '.join(get_args(Source))} or a number from -1 to 1 wanted")
        if not is_number(self.duration) or not 0 < self.duration < np.inf:
            raise InputError(f"duration {self.duration!r}; a positive number of time constants wanted")
        if self.radius not in range(MAX_RADIUS + 1):
            raise InputError(f"radius {self.radius!r}; a whole number from 0 to {MAX_RADIUS} wanted")
        if not self.map.size:
            raise InputError(f"a stage without a free entry: A, B and z are numbers; {FREE!r} somewhere wanted")

    def _pattern(self, name: str) -> tuple[Floats, Flags]:
        """Return the held numbers of a matrix, 0 for free ones, and which entries are free."""
        given, side = getattr(self, name), 2 * self.radius + 1
        given = [[FREE] * side] * side if isinstance(given, str) and given == FREE else given
        rows = given if isinstance(given, Sequence | np.ndarray) else [[given]]
        if isinstance(rows, str) or any(
            isinstance(row, str) or not isinstance(row, Sequence | np.ndarray) for row in rows
        ):
            raise InputError(f"stage: {name} is {shown(given)}; rows of numbers and {FREE!r}, or {FREE!r}, wanted")
        free = [[isinstance(entry, str) and entry == FREE for entry in row] for row in rows]
        numbers = [
            [0.0 if mark else entry for entry, mark in zip(*both, strict=True)] for both in zip(rows, free, strict=True)
        ]
        return checked_weights("stage", name, numbers), np.array(free, bool)

    @cached_property
    def template(self) -> Template:
        """The template whose free entries are 0, and whose terms have their own weights."""
        z = 0.0 if self.z == FREE else checked_number("stage", "z", self.z)
        return Template(self._pattern("A")[0], self._pattern("B")[0], z, "stage", self.terms)

    @cached_property
    def first(self) -> Floats:
        """All numbers of `template`: the weights in the order of `weights_of`, then z."""
        return np.append(weights_of(layered(self.template)), self.template.z)

    @cached_property
    def map(self) -> Floats:
        """The matrix (numbers, free numbers) that adds free numbers to `first`; a column is one group of entries."""
        control, feedback = self.template.control_terms, self.template.feedback_terms
        matrices = [self._pattern("B")[1], *(np.ones(t.weights.shape, bool) for t in control),
                    self._pattern("A")[1], *(np.ones(t.weights.shape, bool) for t in feedback)]  # fmt: skip
        columns, at, size = [], 0, self.first.size
        for free in matrices:
            for orbit in _orbits(free, self.symmetry):
                columns.append(np.zeros(size))
                columns[-1][at + orbit] = 1.0
            at += free.size
        if self.z == FREE:
            columns.append(np.eye(size)[-1])
        return np.array(columns).reshape(-1, size).T

    @property
    def self_feedback(self) -> Array:
        """Which free numbers are the centre of A."""
        return np.asarray(self.map[self._before_a + self.template.A.size // 2] > 0)

    @property
    def in_terms(self) -> Array:
        """Which free numbers are changes of the terms' weights."""
        control, feedback = (
            slice(self.template.B.size, self._before_a),
            slice(self._before_a + self.template.A.size, -1),
        )
        return np.asarray(self.map[control].any(axis=0) | self.map[feedback].any(axis=0))

    @property
    def _before_a(self) -> int:
        return self.template.B.size + sum(term.weights.size for term in self.template.control_terms)

    def with_numbers(self, free: Floats, name: str) -> Template:
        """Return the template with its free numbers."""
        numbers = self.first + self.map @ free
        found = with_weights(self.template, numbers[:-1], numbers[-1:])
        assert isinstance(found, Template)
        return Template(found.A, found.B, found.z, name, found.terms)


def _orbits(free: Flags, symmetry: Symmetry) -> list[Array]:
    """Return the groups of free entries (numbered row by row) that are one number."""
    number = np.arange(free.size).reshape(free.shape)
    turned = {"none": [number], "mirror": [number, number[:, ::-1]]}.get(symmetry) or [
        np.rot90(plane, turn) for plane in (number, number.T) for turn in range(4)
    ]
    least = np.min(turned, axis=0)
    groups = [np.flatnonzero(least == first) for first in np.unique(least)]
    for group in groups:
        if 0 < free.ravel()[group].sum() < group.size:
            raise InputError(
                f"symmetry {symmetry!r} with a group of entries of which some are held; all or none wanted"
            )
    return [group for group in groups if free.ravel()[group].all()]
