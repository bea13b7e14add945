"""Range of a scene's models: warnings for dry contacts that pull, deep or wide contacts, and large strains."""

import itertools
from collections.abc import Iterator
from typing import TYPE_CHECKING

import numpy as np

from cnnsim.support import InputError
from tactile.core.loads import F, Q, R
from tactile.elastic.medium import Medium
from tactile.simulator.contacts.adhesion_path import adhesion_table
from tactile.simulator.contacts.height_map import HeightMap
from tactile.simulator.contacts.indenter import LAWS, Indenter
from tactile.simulator.contacts.moving_contact import MovingContact
from tactile.simulator.field import Field
from tactile.simulator.scene.extremes import DEEP, Extremes, checked_field, extremes, may_be_larger

if TYPE_CHECKING:
    from tactile.simulator.scene.scene import Scene

WIDE = 0.5
"""Contact over body radius above which Hertz' law is reported: there its force is 11 % too small under a sphere, 10 %
under a cylinder."""
SQUEEZED = 0.95
"""Indentation of a cylinder's middle over the mean, below which the cover is squeezed out at its ends. Against rigid
cylinders of 2 to 50 thicknesses solved on a grid, the force at a depth is too small by 1 to 4 % at 0.95, 4 to 13 % at
0.9, 14 % at 0.75, 25 % at 0.7 and a third to a half at 0.5; the stiffness by somewhat less."""
SQUEEZED_BY = 1.5
"""Power of that ratio which is a lower bound of the force over the true one in all of these."""
SLIPS = 4.1
"""Contact radius over thickness up to which partial slip was compared with slip solved cell by cell (nu = 1/2 and 0.3,
taxels at 0.3 to 1 of the thickness). Readings of a first pull are wrong by at most 3 %, as on the half-space; of one
that turns back, or changes together with the force, by 2.5 % of the readings under full sliding."""
STICKS = 0.5
"""Contact radius over thickness above which readings of a pull on a sticking flat end, spread like its pressure, are
wrong by more than 2 %. Against the traction that moves the circle rigidly, nu = 1/2, taxels at 0.3 of the thickness:
0.5 % at 0.3, 13 % at 1, 38 % at 2 and half at 4; at nu = 0.3: 7, 20 and 18 % at 1, 2 and 4."""
FLAT = 0.1
"""Gap under a flat end on a curved cover, over the indentation, above which it is reported."""
DOUBT = 0.02
"""Relative error of a height map's force by its cells above which it is reported: for smooth bodies the true error is
at most 1 % below it."""


def out_of_range(scene: "Scene") -> Iterator[str]:
    """Yield one line for each way in which a scene leaves the range of its models.

    Raises:
        InputError: strains above 1, or a contact wider than the sphere that makes it.
    """
    numbered = dict(enumerate((one for one in scene.contacts if isinstance(one, MovingContact)), 1))
    for finger in range(len(scene.arrays)):
        yield from _of_finger(scene, finger, {n: one for n, one in numbered.items() if one.finger == finger})


def _of_finger(scene: "Scene", finger: int, mine: dict[int, MovingContact]) -> list[str]:
    """The lines of one finger: from a few frames, from all where random effects on fields may change the lines."""
    field = checked_field(scene, finger)

    def lines(found: Extremes) -> list[str]:
        return list(_lines(found, mine, field))

    fixed = lines(extremes([field]))
    if not may_be_larger(scene, field, lambda more: lines(more) != fixed):
        return fixed
    every = scene.affected(scene.skin.fields(finger, scene.skin.chunks(finger)), "field", scene.effects, finger)
    return lines(extremes(itertools.chain([field], every)))


def _lines(found: Extremes, mine: dict[int, MovingContact], field: Field) -> Iterator[str]:
    """The lines of one finger with these extremes."""
    if field.bumps is None:
        for number, contact in mine.items():
            yield from _contact(contact, number, found, field)
        for one in field.contacts:
            if isinstance(one, HeightMap):
                yield from _map(one.on_dome(field.rig.curvature), field.medium)
    strain = found.strain
    if strain > 1:
        raise InputError(
            f"{field.array.name}: strains to {strain:.3g}; at most 1 wanted, beyond which nothing is left of the cover,"
            f" and below {DEEP:g} for linear rubber"
        )
    if strain > DEEP:
        yield f"{field.array.name}: strains to {strain:.3g}; below {DEEP:g} wanted: the cover is taken to be linear"


def _contact(contact: MovingContact, number: int, found: Extremes, field: Field) -> Iterator[str]:
    body, name = field.rig.touching(contact.indenter), f"contact {number}, a {contact.indenter.shape}"
    push = contact.path[:, 1 + F]
    sticks = field.rig.work > 0 and body.shape in LAWS
    if sticks and not contact.given_depth:
        law = adhesion_table(body.round, field.medium, field.rig.work, contact.path[:, [0, 1 + F]], False)
        if push.min() < law.force.min():
            yield (
                f"{name}: pulled with {-push.min():.3g} N; at most the pull-off force of {-law.force.min():.3g} N "
                "wanted, beyond which it snaps off and carries nothing"
            )
    if push.min() < 0 and not contact.given_depth and not sticks:
        yield (
            f"{name}: pulled with {-push.min():.3g} N; a dry contact cannot pull: it lifts off and carries nothing"
            + " ([effect.adhesion] lets it stick)" * (body.shape in LAWS)
        )
    if body.shape not in (*LAWS, "cylinder"):
        return
    if body is not contact.indenter:
        name += f" on a curved cover, like one of radius {body.radius * 1e3:.3g} mm"
    index = field.contacts.index(contact)
    force, wide = float(found.forces[index]), float(found.radii[index])
    yield from _size(name, force, wide, body, contact, field.medium)
    if field.rig.curvature and force > 0:
        yield from _fallen(name, body, force, field)


def _map(body: HeightMap, medium: Medium) -> Iterator[str]:
    """Lines for a height map that is pulled, pressed in too deep, or has too large cells."""
    pull = -float(body.path[:, 1 + F].min())
    if pull > 0 and not body.given_depth:
        yield f"height map: pulled with {pull:.3g} N; a dry contact cannot pull: it lifts off"
    deep = body.deepest(medium)
    if not deep > 0:
        return
    yield from _sunk("height map", deep, medium)
    solved = body.pressed(medium)
    if solved.doubt > DOUBT:
        yield (
            f"height map: a contact {solved.width * 1e3:.3g} mm wide on cells of {body.pitch * 1e3:g} mm, which leave "
            f"its force open by about {solved.doubt:.1%}; at most {DOUBT:.0%} wanted, by smaller cells"
        )
    elif deep > solved.width / 2:  # as a ball is that is pressed in by more than its radius
        yield (
            f"height map: {deep * 1e3:.3g} mm deep, {2 * deep / solved.width:.3g} times the half width of its contact; "
            "at most that wanted: the cover is taken to be linear"
        )


def _sunk(name: str, deep: float, medium: Medium) -> Iterator[str]:
    if deep > DEEP * medium.thickness:
        yield (
            f"{name}: {deep * 1e3:.3g} mm deep in a cover of {medium.thickness * 1e3:g} mm; at most {DEEP:g} of it "
            "wanted: the cover is taken to be linear"
        )


def _size(
    name: str, force: float, wide: float, body: Indenter, contact: MovingContact, medium: Medium
) -> Iterator[str]:
    """Lines for a body under this force [N] with a round contact of radius ``wide`` [m]."""
    push = np.array([force])
    deep = float(body.indentation(push, medium)[0])
    if contact.given_depth:
        deep = max(deep, float(contact.path[:, 1 + F].max()))
    if body.shape in LAWS:
        yield from _dragged(name, wide / medium.thickness, contact)
    if body.shape == "sphere":
        yield from _width(name, wide, "in radius", body, "a paraboloid (shape = 'needle' is a sphere)")
    if body.shape == "cylinder":
        from tactile.elastic.lines import cylinder_half_width, line_indentation  # only where called for

        half = cylinder_half_width(push, body.length, body.radius, medium)
        wide = float(half[0])
        yield from _width(name, wide, "to either side", body, "a parabola across")
        middle = float(line_indentation(push, body.length, half, medium, middle=True)[0])
        if np.isfinite(medium.thickness) and middle < SQUEEZED * deep:
            yield (
                f"{name}: its middle sinks in {middle / deep:.2g} times as far as its mean, {SQUEEZED:g} or more "
                f"wanted: so thin a cover is squeezed out at the ends of {body.length * 1e3:g} mm, and its force at "
                f"this depth and its stiffness are too small by up to {1 - max(middle / deep, 0) ** SQUEEZED_BY:.0%}"
            )
        if 2 * wide > body.length:
            yield (
                f"{name}: a contact {2 * wide * 1e3:.3g} mm wide and {body.length * 1e3:g} mm long; at most as wide as "
                "long wanted, for every cross-section is taken for the middle of an endless one"
            )
    if deep > body.radius:
        yield (
            f"{name}: {deep * 1e3:.3g} mm deep, {deep / body.radius:.3g} times its radius; at most the radius wanted: "
            "the cover is taken to be linear"
        )
    yield from _sunk(name, deep, medium)


def _fallen(name: str, body: Indenter, force: float, field: Field) -> Iterator[str]:
    """Line for a curved cover under a flat end or along a cylinder, both of which are taken to be flat."""
    flat, where = {"flat_punch": (body.radius, "rim"), "cylinder": (body.length / 2, "ends")}.get(body.shape, (0.0, ""))
    falls, deep = field.rig.curvature * flat**2 / 2, float(body.indentation(np.array([force]), field.medium)[0])
    if falls > FLAT * deep:
        yield (
            f"{name}: the curved cover falls away by {falls * 1e3:.2g} mm under its {where}, {falls / deep:.2g} of its "
            f"indentation; at most {FLAT:g} wanted: it is taken to be flat there"
        )


def _dragged(name: str, over: float, contact: MovingContact) -> Iterator[str]:
    """Lines for tangential loads on covers too thin for the compared models."""
    pulls = np.hypot(contact.path[:, 1 + Q], contact.path[:, 1 + R]) > 0
    if contact.indenter.shape == "flat_punch" and pulls.any() and over > STICKS:
        yield (
            f"{name}, {over:.2g} thicknesses of the cover in radius, sticks while it is pulled; at most {STICKS:g} "
            "wanted: the pull is spread like its pressure, and its readings are wrong by 13 % at 1 and 38 % at 2"
        )
    if not contact.friction or contact.indenter.shape == "flat_punch" or not pulls.any():
        return
    if over > SLIPS:
        yield (
            f"{name}, {over:.2g} thicknesses of the cover in radius, slips from its rim inwards under a pull; at "
            f"most {SLIPS:g} wanted, up to which its readings are wrong by at most 3 %"
        )


def _width(name: str, wide: float, extent: str, body: Indenter, taken: str) -> Iterator[str]:
    """Line for a contact too wide for Hertz' law, which takes round bodies to be parabolic."""
    said = f"{name}: a contact {wide * 1e3:.3g} mm {extent} of a {body.shape} of radius {body.radius * 1e3:g} mm"
    if wide > body.radius:
        raise InputError(
            f"{said}; at most the {body.shape}'s own wanted, and {WIDE:g} of it for Hertz' law, which takes it for "
            f"{taken}"
        )
    if wide > WIDE * body.radius:
        yield f"{said}; at most {WIDE:g} of it wanted, because Hertz' law takes it for {taken}"
