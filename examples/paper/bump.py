"""The paper's bump (sect. 5): its section in plane stress, and the body of revolution."""

import sys
from dataclasses import dataclass
from functools import cache
from importlib.util import find_spec

import numpy as np
from numpy.typing import ArrayLike

from cnnsim.support import Floats
from cnnsim.support.extras import install_line

if find_spec("skfem") is None:
    sys.exit(f"finite elements wanted: {install_line('fem')}")

from tactile.bump.body import Body
from tactile.bump.kinematics import PLANE, PRESSED, SHEARED
from tactile.bump.law import Mixed, PlaneStress
from tactile.bump.mesh import half_section, whole_section
from tactile.bump.plate import plate_constraint, respond, stiffness
from tactile.bump.probe import Probe
from tactile.bump.shape import Shape
from tactile.elastic.medium import Medium

RUBBER = Medium(0.87e6, 0.499)
"""Young's modulus [Pa] and Poisson's ratio of sect. 5."""
SENSOR = 200e-6
"""Depth [m] at which the paper reads the response."""
INDENTATION = 50e-6
"""[m] Figs. 10 and 11."""
CONTACT = 100e-6
"""Half-width [m] of the top that sticks to the plate: about sqrt(R d) of a sphere on a plane at d = 50 um; the paper
does not state it."""
CONTACTS = (30e-6, 50e-6, 70e-6, 100e-6, 120e-6, 140e-6)
"""Other possible half-widths."""
FINENESS = 0.8
"""Fineness of the meshes: relative errors at the sensor are 1e-4 for displacements, 1e-3 for strains and 3e-3 for
ratios to a shear strain near zero; see Fig. 12."""


@dataclass(frozen=True)
class Loaded:
    """A bump under the plate's two loads, per metre that the plate moves (and of thickness, in the plane).

    ``bodies`` and ``states`` for press and shift; ``stiffness`` force over displacement of the plate.
    """

    bodies: tuple[Body, Body]
    states: tuple[Floats, Floats]
    stiffness: tuple[float, float]

    def displacement(self, points: Floats) -> tuple[Floats, Floats]:
        """Return the (x, z) displacements (n, 2) under the press and under the shift, at theta = 0."""
        pressed, shifted = (
            Probe(body, points).displacement(state) for body, state in zip(self.bodies, self.states, strict=True)
        )
        if shifted.shape[1] == 3:  # (U + V, U - V, W)
            shifted = np.stack([(shifted[:, 0] + shifted[:, 1]) / 2, shifted[:, 2]], axis=-1)
        return pressed, shifted

    def strain(self, points: Floats) -> tuple[Floats, Floats]:
        """Return the (xz, zz) strains (n, 2) under the press and under the shift, at theta = 0."""
        both = (Probe(body, points).strain(state) for body, state in zip(self.bodies, self.states, strict=True))
        pressed, shifted = (strain[:, [0, 2], [2, 2]] for strain in both)
        return pressed, shifted


@cache
def loaded(contact: float = CONTACT, solid: bool = False, fineness: float = FINENESS) -> Loaded:
    """Return the section in plane stress, or the body of revolution if ``solid``."""
    shape = Shape(contact=contact)
    if solid:
        mesh = half_section(shape, fineness, sensor=SENSOR)
        bodies = Body(mesh, PRESSED, Mixed(RUBBER)), Body(mesh, SHEARED, Mixed(RUBBER))
    else:
        bodies = (Body(whole_section(shape, fineness, sensor=SENSOR), PLANE, PlaneStress(RUBBER)),) * 2
    constraints = plate_constraint(bodies[0], shape, "press"), plate_constraint(bodies[1], shape, "shift")
    states = respond(bodies[0], constraints[0]), respond(bodies[1], constraints[1])
    stiff = stiffness(bodies[0], constraints[0], states[0]), stiffness(bodies[1], constraints[1], states[1])
    return Loaded(bodies, states, stiff)


def below(depths: ArrayLike, x: float = 0.0) -> Floats:
    """Return points (n, 2) at depths [m] under the body's surface."""
    z = np.atleast_1d(np.asarray(depths, dtype=np.float64))
    return np.stack([np.full(z.shape, x), z], axis=-1)
