"""Prospects of choosing effects: what leaving some out may save in one run, from the sizes of a scene alone."""

import math
from typing import Any

import numpy as np

from tactile.core.loads import COLUMNS, FORCE, F
from tactile.elastic.halfspace import point_scale
from tactile.simulator.choice.chain import Named
from tactile.simulator.choice.effect_bounds import EffectBounds
from tactile.simulator.choice.extremes import PEAKS, SPREAD
from tactile.simulator.choice.field_bounds import LARGE
from tactile.simulator.choice.forces import unseen
from tactile.simulator.choice.trials import (
    CHANCE,
    EFFECT,
    FRAMES,
    READING,
    SAVED,
    frame_time,
    is_body,
    trial_pays,
)
from tactile.simulator.contacts.height_map import HeightMap
from tactile.simulator.contacts.indenter import LAWS
from tactile.simulator.contacts.moving_contact import MovingContact
from tactile.simulator.contacts.sliding_texture import SlidingTexture
from tactile.simulator.effect import sticks
from tactile.simulator.scene.scene import Scene
from tactile.simulator.seen import Seen
from tactile.simulator.slopes import VALUE, Slopes

CHOICE = 600e-6
"""Time of a choice [s] by bounds, however few frames there are."""
CHOICE_POINTS, IDEAL_POINT = 200e-6, 7e-9
"""The same where points alone press, and for every load on every reading."""
LIKELY, HALF = 0.5, 0.07
"""Where points press and all of the tolerance is left for it, the share of the time of effects that a scene describes
which is saved, about; and the tolerance where half of what typical ones take is: they change hundredths of the peak."""
IDEAL, IDEAL_BODY, IDEAL_LINE = 0.5e-6, 4e-6, 25e-6
"""Time of a frame of the skin without effects [s], for every load, body, and line or map."""
IDEAL_PAIR = 12e-9
"""The same for every one of them on every taxel."""
USUAL = 0.5
"""The peak as a part of what it would be if every load pressed its hardest right over a taxel."""
FEW = 0.25
"""Of what may be saved where bodies press for few frames, about so much is: bounds alone decide, and they are loose."""
JUMPS = 10.0
"""A reading is taken to go so many times from zero to its peak in a recording."""


def may_pay(scene: Scene, effects: list[Named], tolerance: float) -> bool:
    """Whether choosing effects costs less than leaving some out may save in one run: a guess, made in no time.

    Every load is taken to press its hardest right over a taxel at once, for which bounds need no field.
    """
    few = scene.samples < FRAMES and any(map(is_body, scene.contacts))
    enough = (_cost(scene) + CHOICE) / (FEW if few else CHANCE)
    acting = [effect for _, effect in effects if not effect.off]
    fixed = [effect for effect in acting if effect.STAGE == "field" and not effect.RANDOM]
    layered = any(name == "finite_thickness" and not effect.off for name, effect in effects)
    shares = [effect.saves(bool(scene.loads), layered) if "saves" in effect.SAYS else SAVED for effect in fixed]
    behind = [effect for effect in acting if effect.STAGE != "field"]
    each = [EFFECT + READING * 3 * array.rows * array.cols * scene.samples for array in scene.arrays]
    if _frames(scene) * sum(shares) + len(behind) * sum(each) <= enough:  # whatever they do
        return False
    fingers = [_saved(scene, finger, fixed, shares, tolerance) for finger in range(len(scene.arrays))]
    saved = sum(one for one, _ in fingers)
    open_ends = [(seen, one) for one, (_, seen) in zip(each, fingers, strict=True) if seen]
    if saved <= enough < saved + len(behind) * sum(one for _, one in open_ends):  # only then these decide
        for seen, one in open_ends:
            saved += one * sum(effect.reach(seen) <= tolerance * seen.largest for effect in behind)
    return saved > enough


def points_may_pay(scene: Scene, bounds: EffectBounds, tolerance: float) -> bool:
    """The same where points alone press: by what the effects take, and what of the tolerance is left for them.

    A converter that is left out takes half a step of it, and one whose steps are so coarse, for a usual peak, that it
    stays lets nothing before it be left out. That is told by the forces along paths alone.
    """
    left = 1.0
    if bounds.step:
        usual = 2 * tolerance * USUAL * bounds.highest
        if bounds.step >= usual:
            return False
        left -= bounds.step / usual
    fingers, named = len(scene.arrays), {name for name, _ in scene.effects}
    typical = tolerance / (tolerance + HALF)
    readings = 3 * scene.samples * sum([array.rows * array.cols for array in scene.arrays])
    saved = 0.0
    for name, effect in (*bounds.on_fields, *bounds.on_frames):
        each, reading = effect.PRICE
        saved += (LIKELY if name in named else typical) * (each * fingers + reading * readings)
    return left * saved > CHOICE_POINTS * fingers + IDEAL_POINT * len(scene.loads) * readings / fingers


def _cost(scene: Scene) -> float:
    """Time [s] of the skin without effects, from which bounds follow."""
    taxels = max(array.rows * array.cols for array in scene.arrays)
    each = IDEAL * len(scene.loads) + IDEAL_PAIR * taxels * (len(scene.loads) + len(scene.contacts))
    for contact in scene.contacts:
        lines = isinstance(contact, MovingContact) and contact.indenter.shape in ("edge", "cylinder")
        if lines or not isinstance(contact, MovingContact | SlidingTexture):
            each += IDEAL_LINE
        else:
            each += IDEAL_BODY if is_body(contact) else IDEAL
    return scene.samples * each


def _frames(scene: Scene) -> float:
    """Time [s] of all frames with all effects on, if all that presses did so on every finger."""
    count, bodies = len(scene.loads) + len(scene.contacts), any(map(is_body, scene.contacts))
    return scene.samples * sum([frame_time(count, array.rows * array.cols, bodies) for array in scene.arrays])


def _saved(
    scene: Scene, finger: int, fixed: list[Any], shares: list[float], tolerance: float
) -> tuple[float, Seen | None]:
    """Time [s] of the fixed effects on one finger's field that may be small enough, and the readings' bounds.

    These only where effects behind the field may be small, too.
    """
    array, medium = scene.arrays[finger], scene.skin.medium(finger)
    mine = [one for one in (*scene.loads, *scene.contacts) if one.finger == finger]
    force = sum(_hardest(one, medium) for one in mine)
    bodies = any(is_body(one) for one in mine)
    if not math.isfinite(force):
        return math.inf if scene.samples >= FRAMES else 0.0, None
    scale = point_scale(array.depth, medium)[0]
    highest = VALUE[array.quantity] * scale * force or scene.full_scale * scene.unit(finger)
    fall = array.depth ** -np.array([0.0, 2, 3, 4])
    slopes = Slopes(array, medium, scale * array.depth**2 * force * fall, force, highest, not bodies)
    change = highest * min(1.0, JUMPS / scene.samples)
    seen = unseen(scene, finger, highest)._replace(change=change)
    sizes = [effect.most(slopes) / highest if "most" in effect.SAYS else math.inf for effect in fixed]
    frame = frame_time(len(mine), seen.taxels, bodies) * min(1.0, sum(shares))
    saved, open_end = 0.0, bodies and math.inf in sizes
    few = bodies and scene.samples < FRAMES  # no trials, and bounds only where bodies press as on the ideal skin
    if not (few and open_end and (any(getattr(one, "given_depth", False) for one in mine) or any(map(sticks, fixed)))):
        for size, share in zip(sizes, shares, strict=True):
            tried = scene.samples >= FRAMES and trial_pays(share, frame, scene.samples, PEAKS + SPREAD)
            saved += (size <= (LARGE if tried else 1.0) * tolerance) * share * frame * scene.samples
    return saved, None if few and open_end else seen


def _hardest(contact: Any, medium: Any) -> float:
    """The largest force [N] of what presses, infinite where nothing tells it but a computation."""
    if isinstance(contact, SlidingTexture):
        return contact.force * math.hypot(1.0, contact.material.static)
    if isinstance(contact, HeightMap | MovingContact) and contact.given_depth:
        if isinstance(contact, HeightMap) or contact.indenter.shape not in LAWS:
            return math.inf
        return float(contact.indenter.force_at(np.array([contact.path[:, 1 + F].max()]), medium)[0])
    path = getattr(contact, "path", None)
    if path is None or path.shape[1] <= COLUMNS:  # a map's strength
        return math.inf
    forces = path[:, 1:][:, FORCE]
    return math.sqrt(float(np.einsum("nc,nc->n", forces, forces).max()))
