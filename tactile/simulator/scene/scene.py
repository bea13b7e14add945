"""Scenes: what touches the fingers' covers, and the frames the taxels would give."""

import heapq
import warnings
import zlib
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, replace
from functools import cached_property
from html import escape
from typing import TYPE_CHECKING, Any, TypeVar

import numpy as np

from cnnsim.support import Floats
from cnnsim.support.keywords import spelled
from tactile.core.frame import Frame, TaxelArray
from tactile.simulator.batch import Batch
from tactile.simulator.contacts.moving_load import MovingLoad
from tactile.simulator.field import Contact, Field
from tactile.simulator.ideal_skin import IdealSkin
from tactile.simulator.scene.checks import check, listed
from tactile.simulator.scene.model_range import out_of_range
from tactile.simulator.scene.unit_range import doubtful_units
from tactile.simulator.summation import ACCURACY

if TYPE_CHECKING:
    from tactile.simulator.bump_cover import Bumps

Item = TypeVar("Item")
UNUSED = np.random.default_rng(0)
"""The generator of effects that are not random: making one takes longer than some of these effects."""
FULL_SCALE = 0.1
"""Default of the largest strain the electronics are made for, reached by the paper's needle."""


class ModelRangeWarning(UserWarning):
    """A scene is computed outside the range of its models."""


def named_effects(effects: Iterable[Any]) -> tuple[tuple[str, Any], ...]:
    """Return (name, effect) pairs in the order in which the effects act; given pairs keep their order."""
    given = listed("effects", effects)
    if all(isinstance(one, tuple) for one in given):
        return tuple(given)
    from tactile.simulator.effects import ORDER, effect_name  # only where called for

    named = [(effect_name(one), one) for one in given]
    return tuple(sorted(named, key=lambda one: ORDER.index(one[0])))


def under_covers(arrays: Iterable[TaxelArray], effects: Iterable[tuple[str, Any]]) -> tuple[TaxelArray, ...]:
    """Return the arrays with the thickness of their covers by ``finite_thickness``, None for a half-space."""
    cover = dict(effects).get("finite_thickness")
    given = [(array, None if cover is None else cover.over(array)) for array in arrays]
    return tuple(array if array.thickness == thick else replace(array, thickness=thick) for array, thick in given)


@dataclass(frozen=True)
class Scene:
    """A simulated recording, as a ``Source``: every finger is sampled at the times k / rate, k = 0, 1, ...

    Arguments: ``rate`` [Hz]; ``duration`` [s]; ``modulus``: Young's modulus of the cover [Pa]; ``loads``: point loads;
    ``contacts``: all other contacts. Loads and contacts on a finger add. ``effects``, as ``make_effect`` returns them,
    are put in the order in which they act; pairs (name, effect) keep their order; none gives the paper's ideal skin.
    ``full_scale``: the largest strain the electronics are made for. ``accuracy``: error of the field relative to its
    peak, from 1e-7; 0 for the finest: rounding on a half-space. ``seed``: every effect of every finger draws from a
    generator of its own, which does not depend on the other effects. ``bumps``: the shape of the cover with a bump over
    every taxel, None for a flat cover.

    Iterating warns by `ModelRangeWarning` of every line of ``range_notes``.

    Raises:
        InputError: a rate, duration or modulus that is not positive, no array or two of one name, an array of force
            on bumps, a load or contact on a missing finger; with the first frame, what ``range_notes`` raises.
    """

    title: str
    rate: float
    duration: float
    modulus: float
    arrays: tuple[TaxelArray, ...]
    loads: tuple[MovingLoad, ...] = ()
    contacts: tuple[Contact, ...] = ()
    effects: tuple[tuple[str, Any], ...] = ()
    full_scale: float = FULL_SCALE
    seed: int = 0
    bumps: "Bumps | None" = None
    accuracy: float = ACCURACY

    @spelled()
    def __init__(
        self, title: str, rate: float, duration: float, modulus: float, arrays: Iterable[TaxelArray],
        loads: Iterable[MovingLoad] = (), contacts: Iterable[Contact] = (),
        effects: Iterable[Any] = (), full_scale: float = FULL_SCALE, seed: int = 0, bumps: "Bumps | None" = None,
        accuracy: float = ACCURACY,
    ) -> None:  # fmt: skip
        given = {
            "title": title, "rate": rate, "duration": duration, "modulus": modulus,
            "arrays": under_covers(listed("arrays", arrays, TaxelArray), acting := named_effects(effects)),
            "loads": listed("loads", loads), "contacts": listed("contacts", contacts), "effects": acting,
            "full_scale": full_scale, "seed": seed, "bumps": bumps, "accuracy": accuracy,
        }  # fmt: skip
        for name, value in given.items():
            object.__setattr__(self, name, value)
        check(self)

    def __repr__(self) -> str:
        pressing = len(self.loads) + len(self.contacts)
        fingers = ", ".join(f"{array.name} {array.rows} x {array.cols}" for array in self.arrays)
        effects = ", ".join(name for name, _ in self.effects) or "no effects"
        return (
            f"Scene({self.title!r}, {fingers}, {self.duration:g} s at {self.rate:g} Hz, {pressing} pressing, {effects})"
        )

    def _repr_html_(self) -> str:
        rows = "".join(
            f"<tr><td>{escape(array.name)}</td><td>{array.rows} x {array.cols} of {array.quantity}</td>"
            f"<td>{array.pitch * 1e3:g} mm apart, {array.depth * 1e3:g} mm deep</td><td>"
            + escape("; ".join(repr(one) for one in (*self.loads, *self.contacts) if one.finger == number))
            + "</td></tr>"
            for number, array in enumerate(self.arrays)
        )
        return f"<b>{escape(self.title)}</b>: {self.duration:g} s at {self.rate:g} Hz<table>{rows}</table>"

    @property
    def frames(self) -> int | None:
        """Number of frames over all fingers, None where frames get lost."""
        if any(getattr(effect, "drops", 0) > 0 for _, effect in self.effects):
            return None
        return self.samples * len(self.arrays)

    @cached_property
    def samples(self) -> int:
        """Number of frames of each finger."""
        return max(1, round(self.rate * self.duration))

    def unit(self, finger: int) -> float:
        """The reading of strain 1: 1, or E [Pa] where stress is read, or E times the square of the pitch [N]."""
        array = self.arrays[finger]
        return {"strain": 1.0, "stress": self.modulus, "force": self.modulus * array.pitch**2}[array.quantity]

    @cached_property
    def skin(self) -> IdealSkin:
        """The skin without effects."""
        return IdealSkin(
            self.arrays, self.modulus, (*self.loads, *self.contacts), self.rate, self.samples, self.accuracy,
            self.bumps,
        )  # fmt: skip

    def loads_at(self, finger: int, times: Floats) -> Floats:
        """Return the true loads (times, contacts, 5), rows (x, y, Q, R, F), on a finger.

        On the cover with all fixed effects, on which the force of a contact of given depth depends; without random
        effects.
        """
        field = self.fixed_field(self.skin.field(finger, times), finger)
        return field.loads.totals

    def fixed_field(self, field: Field, finger: int) -> Field:
        """A field with the effects that are not random."""
        fixed = [(name, effect) for name, effect in self.effects if not effect.RANDOM]
        return next(self.affected([field], "field", fixed, finger))

    def random(self, name: str, finger: int) -> np.random.Generator:
        """The generator of one effect on one finger: `numpy.random.default_rng` of seed, finger and name."""
        return np.random.default_rng((self.seed, finger, zlib.crc32(name.encode())))

    def batches(self, finger: int) -> Iterator[Batch]:
        """The frames of one finger, many at a time: field, effects on it, effects on frames; warns as iterating."""
        self._check_range()
        fields = self.affected(self.skin.fields(finger, self.skin.chunks(finger)), "field", self.effects, finger)
        return self.affected((self.batch(finger, field) for field in fields), "frames", self.effects, finger)

    def affected(
        self, stream: Iterable[Item], stage: str, effects: Iterable[tuple[str, Any]], finger: int
    ) -> Iterator[Item]:
        """The fields or batches of one finger after those of the effects that act at this stage."""
        for name, effect in effects:
            if stage == effect.STAGE and not effect.off:
                stream = effect(stream, self.random(name, finger) if effect.RANDOM else UNUSED)
        return iter(stream)

    def batch(self, finger: int, field: Field) -> Batch:
        """The field as frames."""
        count, unit = len(field.times), self.unit(finger)
        return Batch(
            field.array,
            unit,
            self.full_scale * unit,
            field.times,
            np.arange(field.first, field.first + count),
            field.values,
            np.ones(field.values.shape[:3], bool),
        )

    @cached_property
    def range_notes(self) -> tuple[str, ...]:
        """One line for each way in which the scene leaves the range of its models.

        Random effects on fields count by the frames that they give. Once read, iterating does not warn again.

        Raises:
            InputError: what has no meaning at all: strains above 1, a contact wider than the sphere that makes it.
        """
        return (*out_of_range(self), *doubtful_units(self))

    def __iter__(self) -> Iterator[Frame]:
        self._check_range()
        streams = [self._frames_of(finger) for finger in range(len(self.arrays))]
        return heapq.merge(*streams, key=lambda frame: frame.t) if len(streams) > 1 else streams[0]

    def _frames_of(self, finger: int) -> Iterator[Frame]:
        for batch in self.batches(finger):  # checked already
            for k, (t, sequence) in enumerate(zip(batch.t.tolist(), batch.sequence.tolist(), strict=True)):
                yield Frame(finger, t, sequence, batch.values[k], batch.valid[k])

    def _check_range(self) -> None:
        """Warn of every line of ``range_notes``, once."""
        if "range_notes" not in self.__dict__:
            for line in self.range_notes:
                warnings.warn(f"{self.title}: {line}", ModelRangeWarning, stacklevel=3)

    def with_effects(self, effects: Iterable[Any], accuracy: float | None = None) -> "Scene":
        """Return the scene with other effects, and with another ``accuracy`` of the field if one is given."""
        return replace(self, effects=named_effects(effects), accuracy=self.accuracy if accuracy is None else accuracy)
