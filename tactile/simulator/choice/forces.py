"""What the forces on a scene's fingers alone say of the readings, before any field is computed."""

import math
from typing import Any

import numpy as np

from tactile.core.loads import F
from tactile.elastic.halfspace import point_scale
from tactile.elastic.medium import Medium
from tactile.simulator.contacts.adhesion_path import REACH
from tactile.simulator.contacts.height_map import HeightMap
from tactile.simulator.contacts.indenter import LAWS
from tactile.simulator.contacts.mounting import STILL, Rig
from tactile.simulator.contacts.moving_contact import MovingContact
from tactile.simulator.contacts.moving_load import MovingLoad
from tactile.simulator.scene.scene import Scene
from tactile.simulator.seen import Seen
from tactile.simulator.slopes import VALUE

WIDEST = 10.0
"""Thicknesses up to which the radius of a body that does not go through a layer keeps its contact within the tables."""


WIDER = 2.0
"""By what the force grows when a contact is a quarter wider, as the table of what sticks may be: 1.25 cubed."""
NEARLY = 0.7
"""Contact over tip radius up to which that holds of a round tip."""


def highest_reading(scene: Scene) -> float:
    """Bound of the readings of the ideal skin: of every load at its hardest, right over a taxel at once.

    Infinite where other things than loads press, or the cover has bumps. Along a path forces change linearly, so that
    they are hardest at a keyframe.
    """
    if scene.bumps is not None or scene.contacts:
        return math.inf
    forces = [0.0] * len(scene.arrays)
    for load in scene.loads:
        forces[load.finger] += _hardest(load)
    return max(
        VALUE[array.quantity] * point_scale(array.depth, scene.skin.medium(finger))[0] * force
        for finger, (array, force) in enumerate(zip(scene.arrays, forces, strict=True))
    )


def _hardest(load: MovingLoad) -> float:
    return max([math.hypot(*force) for force in load.path[:, 3:].tolist()])


def unseen(scene: Scene, finger: int, highest: float) -> Seen:
    """The bounds of a finger's readings of which no more is known than how large they may be."""
    unit = scene.unit(finger)
    return Seen(
        scene.arrays[finger], unit, scene.full_scale * unit, scene.rate, scene.samples, highest, (-highest, highest),
        2 * highest,
    )  # fmt: skip


def sinks_in(contact: Any, medium: Medium, thickness: float, rig: Rig = STILL) -> float:
    """Bound of how deep [m] what presses goes into a layer: as deep as into the half-space; infinite where unknown.

    0 of what has no law of its own, which cannot go through. A round tip of radius R under s E* R^2 has a contact of
    lam R, delta = lam (s + lam) / (1 + lam^2) R, which grows with lam; lam is at most that of Hertz, (3 s / 4)^(1/3).
    What sticks sinks in as under the force of Johnson, Kendall and Roberts, with what its table and a layer may add.

    Arguments: ``medium``: the half-space, of the layer's own Poisson's ratio; ``thickness`` [m] of the layer; ``rig``:
    what sticks, and how curved it is.
    """
    if isinstance(contact, HeightMap):
        return math.inf
    if not isinstance(contact, MovingContact) or contact.indenter.shape in ("point", "edge", "disc"):
        return 0.0
    body, push = rig.touching(contact.indenter), max(float(contact.path[:, 1 + F].max()), 0.0)
    if body.shape not in LAWS or contact.indenter.radius > WIDEST * thickness:
        return math.inf
    if contact.given_depth:
        if rig.work == 0:
            return push
        push = float(body.force_at(np.array([push]), medium)[0])  # a layer is stiffer, and yields less to more force
    if rig.work > 0:
        held, push = 3 * math.pi * rig.work * body.radius, REACH * max(push, rig.work * body.radius)
        if body.shape != "flat_punch":
            push = WIDER * (push + held + math.sqrt(2 * held * push + held * held))
    if body.shape != "needle":
        return float(body.indentation(np.array([push]), medium)[0])
    s = push / (medium.contact_modulus * body.radius**2)
    lam = min((0.75 * s) ** (1 / 3), 1.0)
    deep = float(body.radius * lam * (s + lam) / (1 + lam * lam))
    return math.inf if rig.work > 0 and lam > NEARLY else deep  # its table goes on to where its sides are steep
