"""Fig. 12: the response at the sensor, 200 um deep on the axis, against the indentation."""

from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np

from cnnsim.support import Floats
from examples.paper.bump import CONTACT, CONTACTS, FINENESS, RUBBER, SENSOR, below, loaded
from examples.paper.claims import Claim
from examples.paper.drawing import figure, plot_curves, save
from tactile.bump.body import Body
from tactile.bump.finite import push_to
from tactile.bump.kinematics import HALF, PLANE
from tactile.bump.law import PlaneStress
from tactile.bump.mesh import half_section, whole_section
from tactile.bump.plate import plate_constraint
from tactile.bump.probe import Probe
from tactile.bump.shape import Shape
from tactile.bump.touch import lower

STEPS = np.arange(10e-6, 101e-6, 10e-6)
DEEPEST = 80e-6
"""[m] Largest indentation: a top glued over 100 um to each side folds at its edge beyond 90 um."""
MESHES = (0.875, 1.0, 1.125, 1.25)
"""Fineness of the meshes for the mesh error of a ratio, over that of the other figures."""
STRAIGHT = 0.1
"""Largest relative deviation from the small-strain line that counts as close to linear."""


@dataclass(frozen=True)
class Curve:
    """Displacements (n, 2) [m], (x, z), at the sensor for plate displacements (n,) [m]."""

    moved: Floats
    response: Floats

    def bend(self, component: int) -> float:
        """Return the largest relative change of the response per displacement, from the first point's."""
        slope = self.response[:, component] / self.moved
        return float(np.abs(slope / slope[0] - 1).max())


@dataclass(frozen=True)
class Ratio:
    """Normal over shear strain at the sensor: its value, relative mesh error, and relative change per um of depth."""

    value: float
    mesh_error: float
    per_um: float


def shear_over_normal(contact: float, fineness: float, depth: float = SENSOR) -> float:
    """Return shear over normal strain, under a top of this half-width [m] glued to the plate."""
    (pressed,), (shifted,) = loaded(contact, fineness=fineness).strain(below(depth))
    return float(shifted[0] / pressed[1])


@cache
def strain_ratio(contact: float) -> Ratio:
    """Return the mean over the meshes, with their range as the mesh error: it bounds that of all finer ones."""
    found = np.array([shear_over_normal(contact, FINENESS * finer) for finer in MESHES])
    above, under = (shear_over_normal(contact, FINENESS, SENSOR + step) for step in (-1e-6, 1e-6))
    return Ratio(1 / found.mean(), np.ptp(found) / abs(found.mean()), abs(under - above) / 2 / abs(found.mean()))


@cache
def curves() -> tuple[Curve, Curve, Curve, Curve]:
    """Return the glued press, the glued shift and the growing contact at finite strain; the last at small strain."""
    shape = Shape(contact=CONTACT)
    glued = Body(whole_section(shape, 0.7), PLANE, PlaneStress(RUBBER))
    at = Probe(glued, below(SENSOR))
    made = []
    for push, steps in (("press", STEPS[STEPS <= DEEPEST * 1.001]), ("shift", STEPS)):
        constraint = plate_constraint(glued, shape, "press" if push == "press" else "shift")
        steps = np.concatenate([[1e-8], steps])
        made.append(Curve(steps, np.concatenate([at.displacement(push_to(glued, constraint, step)) for step in steps])))
    narrow = Shape(contact=0.1 * Shape().radius)
    body = Body(half_section(narrow, 0.7, touching=True), HALF, PlaneStress(RUBBER))
    at = Probe(body, below(SENSOR))
    for finite in (True, False):
        touches = list(lower(body, narrow, np.arange(2.5e-6, 101e-6, 2.5e-6), finite))
        read = np.concatenate([at.displacement(touch.state) for touch in touches])
        made.append(Curve(np.array([touch.indentation for touch in touches]), read))
    return made[0], made[1], made[2], made[3]


def compare(folder: Path | None) -> list[Claim]:
    """Fig. 12: linearity to 100 um, cross-talk, ratio of normal to shear."""
    press, shift, touching, _ = curves()
    if folder is not None:
        draw(folder / "fig12.png")
    across = float(np.abs(press.response[:, 0] / press.response[:, 1]).max())
    sinks = shift.response[:, 1] / shift.response[:, 0]
    linear = [loaded(contact).displacement(below(SENSOR)) for contact in CONTACTS]
    straight = max(max(abs(p[0, 0] / p[0, 1]), abs(s[0, 1] / s[0, 0])) for p, s in linear)
    ratios, solid, forces, strains = [], [], [], []
    for contact in CONTACTS:
        answer, round_one = loaded(contact), loaded(contact, True)
        (pressed,), (shifted,) = answer.displacement(below(SENSOR))
        ratios.append(pressed[1] / shifted[0])
        forces.append(ratios[-1] * answer.stiffness[1] / answer.stiffness[0])
        (pressed,), (shifted,) = round_one.displacement(below(SENSOR))
        solid.append(pressed[1] / shifted[0])
        (pressed,), (shifted,) = answer.strain(below(SENSOR))
        strains.append(pressed[1] / shifted[0])
    grows = touching.response[:, 1] / touching.moved
    early = float(np.interp(20e-6, touching.moved, grows))
    steepest = int(np.abs(strains).argmax())
    largest = strain_ratio(CONTACTS[steepest])
    strains[steepest] = largest.value
    return [
        Claim("12", "FxUz = FzUx = 0, small strain", "zero", f"{straight:.0e}", bool(straight < 1e-9), "by symmetry"),
        Claim("12", "FxUz = FzUx = 0, finite strain", "zero to 100 um",
              f"FzUx {across:.0e}; FxUz {abs(sinks[-1]):.1%} of FxUx", bool(max(across, abs(sinks[-1])) < 1e-8),
              "symmetry forbids FzUx, and of FxUz only what is odd in the shear: it grows with its square, "
              f"{abs(sinks[5]):.1%} at 50 um"),
        Claim("12", "linear to 100 um, shear load", "close to linear", f"bent by {shift.bend(0):.1%}",
              shift.bend(0) < STRAIGHT, "neo-Hookean, plane stress, the top glued to the plate"),
        Claim("12", "linear to 100 um, normal load, contact fixed", "close to linear",
              f"bent by {press.bend(1):.1%} at {DEEPEST * 1e6:.0f} um", press.bend(1) < STRAIGHT,
              "the same; beyond 90 um the glued edge folds over"),
        Claim("12", "linear to 100 um, normal load, growing contact", "close to linear",
              f"per um at 100 um {grows[-1] / early - 1:+.0%} on that at 20 um", abs(grows[-1] / early - 1) < STRAIGHT,
              "a flat plate on a sphere is no linear contact; a linear answer needs a contact that does not grow; "
              "nodes come off the plate where it would pull; elements of 0.7 times the size change it by 0.04 points"),
        Claim("12", "normal over shear, displacement per um", "about 2", span(ratios),
              all(abs(ratio - 2) < 0.25 for ratio in ratios),
              f"plane stress, contact 30 to 140 um; per newton {span(forces)}; body of revolution {span(solid)}"),
        Claim("12", "normal over shear, the strain that the sensor measures", "similar", span(strains),
              all(abs(ratio - 2) < 0.25 for ratio in np.abs(strains)),
              f"contact 30 to 140 um; the shear strain passes through zero near this depth, see Fig. 11, which makes "
              f"the largest ill-conditioned: 1 um of depth changes it by {largest.per_um:.0%}. Shear over normal has "
              f"no pole: {', '.join(f'{1 / ratio:.4f}' for ratio in strains)}. Mesh error of the largest "
              f"{largest.mesh_error:.1%} (fineness {FINENESS * MESHES[0]:g} to {FINENESS * MESHES[-1]:g} and finer), "
              "of the others a tenth of a percent"),
    ]  # fmt: skip


def span(values: list[float]) -> str:
    """Return the range, or all values if some are negative."""
    return f"{min(values):.2f} to {max(values):.2f}" if min(values) > 0 else f"{', '.join(f'{v:.0f}' for v in values)}"


def draw(path: Path) -> None:
    """Write the figure."""
    press, shift, touching, small = curves()
    um, glued = np.array([0, 100.0]), []
    for curve, component, colour, names in ((press, 1, "tab:blue", "FzUz FzUx"), (shift, 0, "tab:red", "FxUx FxUz")):
        along, across = names.split()
        response, other = curve.response.T[[component, 1 - component]]
        slope = response[0] / curve.moved[0]
        glued += [
            (um, um * slope, "-", colour, f"{along}, small strain"),
            (curve.moved * 1e6, response * 1e6, "o", colour, f"{along}, neo-Hookean"),
            (curve.moved * 1e6, other * 1e6, "x" if component else ".", "k", f"{across}, neo-Hookean"),
        ]
    growing: list[tuple[Any, Any, str, str, str | None]] = [
        (curve.moved * 1e6, curve.response[:, 1] * 1e6, style, "tab:blue", f"FzUz, {name}")
        for curve, style, name in ((small, "--", "small strain"), (touching, "-", "neo-Hookean"))
    ]
    growing.append((um, um * touching.response[7, 1] / touching.moved[7], "-", "0.6", "through 20 µm"))
    drawn, ((left, right),) = figure(2, size=(5.5, 4.6))
    labels = {"xlabel": "the plate's displacement [µm]", "ylabel": "displacement at the sensor [µm]"}
    plot_curves(left, glued, title="the top glued to the plate, 100 µm to each side", **labels)
    plot_curves(right, growing, title="a flat plate with a growing contact", **labels)
    save(drawn, path, "Response 200 µm deep on the axis, plane stress")
