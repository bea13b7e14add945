"""Trials of effects on a few frames of a scene: whether one pays, by what it costs and what leaving out may save."""

from collections.abc import Callable
from dataclasses import replace
from functools import cached_property, partial
from typing import Any

import numpy as np

from cnnsim.support import Floats, InputError, Integers
from tactile.core.loads import FORCE, F
from tactile.simulator.choice.extremes import PEAKS, RAISED, SPREAD, Extremes
from tactile.simulator.contacts.height_map import HeightMap
from tactile.simulator.contacts.mounting import Rises
from tactile.simulator.contacts.moving_contact import MovingContact
from tactile.simulator.field import Field
from tactile.simulator.held_needle import lifted, pushes
from tactile.simulator.ideal_skin import CHUNK
from tactile.simulator.seen import Seen

APART = 4
"""Frames more where bodies stick or are shaken: those where the effects change the forces most, and as many of those
where bodies press with the effects alone."""
CHANCE = 0.5
"""Of effects that are tried, about so many can be left out."""
BEGIN = 300e-6
"""Time of a trial [s] however few frames it has: two fields are set up."""
FRAME, PAIR = 8e-6, 1e-6
"""Time of a frame with all effects on [s], and for every load on every taxel."""
BODY = 25e-6
"""The same of a frame where bodies press: their laws of contact on a layer."""
RISK = 0.05
"""Share of a run's time that trials may take: so much is lost where nothing can be left out after them."""
SAVED = 0.2
"""Share of a frame's time that leaving out an effect on fields saves which does not say what."""
EFFECT, READING = 40e-6, 6e-9
"""Time of an effect on frames [s], in a run of however few frames, and for every reading."""
FRAMES = 2000
"""Frames from which trials pay: set up, its tables and laws made, one takes as long as some hundred frames (10 to 35 %
of runs of 200 to 400), and about a tenth of the frames' time may be saved."""


class Trial:
    """The fields of a finger without effects and with all that are fixed, computed when they are asked for.

    ``ideal``: which frames tell most; ``field`` (times) -> the field without effects, ``acted`` (field) -> with them.
    ``rises``: by how much [m] random effects raise the surface under contacts at most, with the tip radius of each:
    fixed ones that make contacts stiffer are tried at rest, raised and lowered. ``sticks``: whether contacts do with
    the effects, so that they may pull where they would have lifted off.
    """

    def __init__(
        self,
        ideal: Extremes,
        field: Callable[[Floats], Field],
        acted: Callable[[Field], Field],
        rises: Rises = (),
        sticks: bool = False,
    ) -> None:
        self._ideal, self._field, self._acted, self._rises, self._sticks = ideal, field, acted, rises, sticks

    @property
    def frames(self) -> int:
        """How many frames every trial has."""
        count = PEAKS + SPREAD + 2 * APART * self._bends
        return (count + 2 * RAISED) * 3 if self._rises else count

    @property
    def growth(self) -> float:
        """By what readings are larger at most in a trial than at rest."""
        return self._ideal.growth

    @cached_property
    def shaken(self) -> Field:
        """The field without effects on all frames of a short scene of points, else on those that tell most."""
        whole = self._ideal.whole  # bodies' laws are dear
        return whole if whole is not None and self._ideal.slopes.at_points else self._given

    @cached_property
    def _given(self) -> Field:
        times, whole = np.union1d(self._ideal.times, self._apart), self._ideal.whole
        given = self._field(times)
        if whole is not None:  # nothing is computed twice
            given.__dict__["values"] = whole.values[np.rint(times * self._ideal.seen.rate).astype(np.int64)]
        return given

    @cached_property
    def still(self) -> Field:
        """The field with all, at rest, on the frames that tell most."""
        return self._acted(self._given)

    @cached_property
    def pressed(self) -> Field:
        """What presses with all effects, and the readings without: no table of a layer is made for them."""
        with_all = self._acted(self.shaken)
        with_all.__dict__["values"] = self.shaken.values
        if self._ideal.slopes.at_points:  # forces, whatever the cover
            with_all.__dict__["_pushes"] = pushes(self.shaken)
        return with_all

    @cached_property
    def every(self) -> tuple[Field, Field]:
        """The fields without and with all, on the frames that tell most, also raised and lowered by what shakes."""
        if not self._rises:
            return self._given, self.still
        given = self._raised(self._given)
        return given, self._acted(given)

    @cached_property
    def few(self) -> tuple[Field, Field]:
        """The same on the first of them."""
        given = self._raised(self._first) if self._rises else self._first
        return given, self._acted(given)

    @cached_property
    def first(self) -> Field:
        """The field with all, at rest, on those."""
        return self._acted(self._first)

    @cached_property
    def _first(self) -> Field:
        return replace(self._given, times=np.union1d(self._ideal.foremost, self._apart[:1]))

    @property
    def _bends(self) -> bool:
        """Whether bodies may press otherwise with the effects: where they stick, or are shaken."""
        return (self._sticks or bool(self._rises)) and not self._ideal.slopes.at_points

    @cached_property
    def _apart(self) -> Floats:
        """Times [s] at which bodies press most otherwise with the effects, at rest or raised, the first of them most.

        Such as what is held so lightly that its law says how hard it presses; and apart from these what presses with
        the effects alone, such as what pulls instead of lifting off.
        """
        seen, most, found = self._ideal.seen, np.empty((2, 0)), np.empty(0)
        for start in range(0, seen.frames if self._bends else 0, CHUNK):
            given = self._field(np.arange(start, min(start + CHUNK, seen.frames)) / seen.rate)
            apart = np.zeros((2, len(given.times)))
            for rises in ((), self._rises) if self._rises else ((),):
                try:
                    with_all, without = (lifted(one, rises).loads.totals for one in (self._acted(given), given))
                except InputError:  # raised so far, one goes through the cover: its frame is one of the peaks
                    continue
                change = np.abs((with_all - without)[..., FORCE]).sum(axis=2)
                alone = np.where(without[..., F] == 0, change, 0.0)
                apart = np.maximum(apart, [change.sum(axis=1), alone.sum(axis=1)])
            most, found = np.append(most, apart, axis=1), np.append(found, given.times)
            best = np.concatenate([_foremost(kind) for kind in most])
            best = best[np.sort(np.unique(best, return_index=True)[1])]
            most, found = most[:, best], found[best]
        return found

    def _raised(self, given: Field) -> Field:
        count, rig = len(given.times), given.rig
        for rise, tip in self._rises:
            heights = np.repeat((0.0, rise, -rise), count)
            rig = rig.with_move(partial(_lifted, heights), tip)
        return replace(given, times=np.tile(given.times, 3), rig=rig)


def _foremost(changes: Floats) -> Integers:
    """The frames of the largest changes, the first of them most."""
    order = np.argsort(-changes, kind="stable")[:APART]
    return order[changes[order] > 0]


def _lifted(heights: Floats, places: Floats) -> tuple[Floats, Floats]:
    return np.zeros_like(places), heights


def is_body(contact: Any) -> bool:
    """Whether what presses has a shape, and a law of its own."""
    if isinstance(contact, MovingContact):
        return contact.indenter.shape != "point"
    return isinstance(contact, HeightMap)


def frame_time(loads: int, taxels: int, bodies: bool) -> float:
    """Time [s] of a frame of so many loads on so many taxels, with all effects on."""
    return (BODY if bodies else FRAME) + PAIR * loads * taxels


def trial_pays(share: float, frame: float, samples: int, tried: int, trials: int = 1) -> bool:
    """Whether the last of some trials, each of so many frames with and without, may save more than it takes.

    Arguments: ``share`` of a frame's time, ``frame`` [s], that is saved over ``samples`` frames. By counts and times
    that hold roughly anywhere: measured ones would choose otherwise each time.
    """
    cost = 2 * tried * frame + BEGIN
    return CHANCE * share * samples * frame > cost and trials * cost <= RISK * samples * frame


def pays(effect: Any, field: Field, samples: int, tried: int, trials: int, layered: bool) -> bool:
    """Whether a trial of an effect on fields pays, as ``trial_pays`` has it, and only over many frames."""
    if samples < FRAMES:
        return False
    bodies = any(map(is_body, field.contacts))
    loads = field.loads
    frame = frame_time(loads.count, field.taxels.places[..., 0].size, bodies)
    saves = getattr(effect, "saves", None)
    share = SAVED if saves is None else float(saves(bool(loads.points.shape[1]), layered))
    return trial_pays(share, frame, samples, tried, trials)


def pays_behind(effects: int, seen: Seen, field: Field, tried: int) -> bool:
    """Whether a trial of all effects on fields pays, without which so many effects behind them cannot be left out."""
    if seen.frames < FRAMES:
        return False
    bodies = any(map(is_body, field.contacts))
    readings, frame = 3 * seen.taxels * seen.frames, frame_time(len(field.contacts), seen.taxels, bodies)
    cost = BEGIN + 2 * tried * frame
    return CHANCE * effects * (EFFECT + READING * readings) > cost and cost <= RISK * seen.frames * frame
