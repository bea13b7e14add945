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
from tactile.simulator.effect import is_off
from tactile.simulator.field import Contact, Field
from tactile.simulator.ideal_skin import IdealSkin
from tactile.simulator.scene.checks import check, check_effects, listed
from tactile.simulator.scene.model_range import out_of_range
from tactile.simulator.summation import ACCURACY

if TYPE_CHECKING:
    from tactile.simulator.bump_cover import Bumps

Item = TypeVar("Item")
NOTHING = np.random.default_rng(0)
"""What is drawn by effects that draw nothing: a generator of one's own takes longer than some of them."""
FULL_SCALE = 0.1
"""Largest strain the electronics are made for, unless a scene says otherwise: the paper's needle just reaches it."""


class ModelRangeWarning(UserWarning):
    """A scene leaves the range of its models, and is computed all the same."""


def named_effects(effects: Iterable[Any]) -> tuple[tuple[str, Any], ...]:
    """Return effects with their names in the order in which they act; pairs of name and effect are left as they are."""
    given = listed("effects", effects)
    if all(isinstance(one, tuple) for one in given):
        return tuple(given)
    from tactile.simulator.effects import ORDER, effect_name  # only where called for

    named = [(effect_name(one), one) for one in given]
    return tuple(sorted(named, key=lambda one: ORDER.index(one[0])))


def under_covers(arrays: Iterable[TaxelArray], effects: Iterable[tuple[str, Any]]) -> tuple[TaxelArray, ...]:
    """Return the arrays with the thickness that the effects give their covers, None without one: they have no end."""
    cover = dict(effects).get("finite_thickness")
    given = [(array, None if cover is None else cover.over(array)) for array in arrays]
    return tuple(array if array.thickness == thick else replace(array, thickness=thick) for array, thick in given)


@dataclass(frozen=True)
class Scene:
    """A simulated recording, as a ``Source``: every finger is sampled at the times k / rate, k = 0, 1, ...

    ``rate`` [Hz], ``duration`` [s], ``modulus`` Young's modulus of the cover [Pa]; ``loads``: point loads,
    ``contacts``: all else that presses; what acts on one finger adds. ``effects``: (name, effect) in the order in
    which they act, none for the paper's ideal skin; effects alone, as ``make_effect`` gives them, are put in order.
    ``full_scale``: the largest strain the electronics are made for. ``accuracy``: how far the field may be off, of its
    peak, from 1e-7; 0 for the finest there is: rounding on a half-space. ``seed``: every effect of every
    finger draws from a generator of its own, so that none changes with the others. ``bumps``: the cover has one over
    every taxel, None for a flat one.

    When its frames are first asked for it warns, by `ModelRangeWarning`, of all that ``range_notes`` says.

    Raises:
        InputError: a rate, duration or modulus that is not positive, no array or two of one name, an array of force,
            a load or contact on a finger that is not there; with the first frame, what ``range_notes`` raises.
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
            "full_scale": full_scale, "seed": seed, "bumps": bumps,
            "accuracy": accuracy,
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
        """The reading of strain 1: 1, or E [Pa] where stress is read."""
        return self.modulus if self.arrays[finger].quantity == "stress" else 1.0

    @cached_property
    def skin(self) -> IdealSkin:
        """The skin without effects."""
        return IdealSkin(
            self.arrays, self.modulus, (*self.loads, *self.contacts), self.rate, self.samples, self.accuracy,
            self.bumps,
        )  # fmt: skip

    def loads_at(self, finger: int, times: Floats) -> Floats:
        """Return the (times, contacts, 5) rows (x, y, Q, R, F) on a finger: what a localiser should find.

        On the cover as the effects make it, which says how hard a contact of a given depth presses; no random effect.
        """
        sure = [(name, effect) for name, effect in self.effects if not effect.RANDOM]
        (field,) = self.affected([self.skin.field(finger, times)], "field", sure, finger)
        return field.loads.totals

    def random(self, name: str, finger: int) -> np.random.Generator:
        """The generator of one effect on one finger: `numpy.random.default_rng` of seed, finger and name."""
        given: Any = self.seed, finger, zlib.crc32(name.encode())
        if self.seed < 1 << 32:  # the same numbers as one array take half the time
            given = np.array(given, np.uint32)
        return np.random.Generator(np.random.PCG64(np.random.SeedSequence(given)))

    def batches(self, finger: int) -> Iterator[Batch]:
        """The frames of one finger, many at a time: field, effects on it, effects on frames."""
        fields = self.affected(self.skin.fields(finger, self.skin.pieces(finger)), "field", self.effects, finger)
        return self.affected((self.batch(finger, field) for field in fields), "frames", self.effects, finger)

    def affected(
        self, stream: Iterable[Item], stage: str, effects: Iterable[tuple[str, Any]], finger: int
    ) -> Iterator[Item]:
        """The fields or batches of one finger after those of the effects that act at this stage."""
        for name, effect in effects:
            if stage == effect.STAGE and not is_off(effect):
                stream = effect(stream, self.random(name, finger) if effect.RANDOM else NOTHING)
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
        """Where the scene leaves the range of its models, a line each; who asks before the frames do tells it himself.

        Raises:
            InputError: what has no meaning at all: strains above 1, a contact wider than the sphere that makes it.
        """
        return tuple(out_of_range(self))

    def __iter__(self) -> Iterator[Frame]:
        if "range_notes" not in self.__dict__:  # else they were told
            for line in self.range_notes:
                warnings.warn(f"{self.title}: {line}", ModelRangeWarning, stacklevel=2)
        streams = [self._frames_of(finger) for finger in range(len(self.arrays))]
        return heapq.merge(*streams, key=lambda frame: frame.t) if len(streams) > 1 else streams[0]

    def _frames_of(self, finger: int) -> Iterator[Frame]:
        for batch in self.batches(finger):
            for k, (t, sequence) in enumerate(zip(batch.t.tolist(), batch.sequence.tolist(), strict=True)):
                yield Frame(finger, t, sequence, batch.values[k], batch.valid[k])

    def with_effects(self, effects: Iterable[tuple[str, Any]], accuracy: float | None = None) -> "Scene":
        """The same scene with other effects, and with what was found out about it without any.

        With another ``accuracy`` of the field, if one is given.
        """
        acting = named_effects(effects)
        skin = self.skin if accuracy is None else self.skin.to_accuracy(accuracy)
        made: Scene = object.__new__(type(self))
        made.__dict__.update(
            self.__dict__,
            effects=acting,
            arrays=under_covers(self.arrays, acting),
            skin=skin,
            accuracy=skin.accuracy,
        )
        made.__dict__.pop("range_notes", None)
        check_effects(made)
        return made
