"""Trials of effects on a few frames of a scene: whether one pays, by what it costs and what leaving out may save."""

from collections.abc import Callable
from dataclasses import replace
from functools import cached_property
from typing import Any

from cnnsim.support import Floats
from tactile.simulator.contacts.height_map import HeightMap
from tactile.simulator.contacts.moving_contact import MovingContact
from tactile.simulator.field import Field
from tactile.simulator.scene.extremes import Extremes
from tactile.simulator.scene.scene import Scene
from tactile.simulator.seen import Seen

CHANCE = 0.5
"""Of effects that are tried, about so many can be left out."""
BEGIN = 300e-6
"""Time of a trial [s] however few frames it has: two fields are set up."""
FRAME, PAIR = 5e-6, 0.1e-6
"""Time of a frame with all effects on [s], and for every load on every taxel."""
SAVED = 0.2
"""Share of a frame's time that leaving out an effect on fields saves which does not say what."""
EFFECT, READING = 40e-6, 6e-9
"""Time of an effect on frames [s], in a run of however few frames, and for every reading."""
FRAMES = 2000
"""Frames from which choosing pays where bodies press: their laws make a trial as dear as some hundred frames, and about
a tenth of the frames' time may be saved."""


class Trial:
    """The fields of a finger without effects and with all that are fixed, computed when they are asked for.

    ``ideal``: which frames tell most; ``field`` (times) -> the field without effects, ``acted`` (field) -> with them.
    """

    def __init__(self, ideal: Extremes, field: Callable[[Floats], Field], acted: Callable[[Field], Field]) -> None:
        self._ideal, self._field, self._acted = ideal, field, acted

    @cached_property
    def shaken(self) -> Field:
        """The field without effects on all frames of a short scene of points, else on those that tell most."""
        whole = self._ideal.whole  # bodies' laws are dear
        return whole if whole is not None and self._ideal.slopes.at_points else self._given

    @cached_property
    def _given(self) -> Field:
        return self._field(self._ideal.times)

    @cached_property
    def every(self) -> tuple[Field, Field]:
        """The fields without and with all, on the frames that tell most."""
        return self._given, self._acted(self._given)

    @cached_property
    def few(self) -> tuple[Field, Field]:
        """The same on the first of them."""
        first = replace(self._given, times=self._ideal.foremost)
        return first, self._acted(first)


def may_pay(scene: Scene) -> bool:
    """Whether choosing effects costs less than leaving some out may save in one run."""
    return scene.samples >= FRAMES or not any(_is_body(contact) for contact in scene.contacts)


def _is_body(contact: Any) -> bool:
    if isinstance(contact, MovingContact):
        return contact.indenter.shape != "point"
    return isinstance(contact, HeightMap)


def pays(effect: Any, field: Field, samples: int, tried: int) -> bool:
    """Whether a trial of so many frames costs less than leaving out the effect may save over all frames.

    By counts and times that hold roughly anywhere: measured ones would choose otherwise each time.
    """
    loads = field.loads
    count = loads.points.shape[1] + sum(disc.radii.shape[1] for disc in loads.discs)
    frame = FRAME + PAIR * count * field.taxels.places[..., 0].size
    saves = getattr(effect, "saves", None)
    share = SAVED if saves is None else float(saves(field))
    return CHANCE * share * samples > tried + BEGIN / frame


def pays_behind(effects: int, seen: Seen) -> bool:
    """Whether a trial of all effects on fields pays, without which so many effects behind them cannot be left out."""
    readings = 3 * seen.taxels * seen.frames
    return CHANCE * effects * (EFFECT + READING * readings) > 2 * BEGIN
