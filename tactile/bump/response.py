"""Response of taxels around a bump to the force on its plate: a table over radii from finite elements.

A body of revolution answers a force (Q, R, F) on its axis with five functions of the distance rho: as in
``elastic.unit_disc``, with (c, s) the direction from the bump to the taxel and a = Q c + R s,

    zz = N_zz(F) + a S_zz,    xz = c N_rz(F) + Q S_even - (2 c a - Q) S_odd,    yz alike

At small strain N is F times its value per newton; at finite strain N and S are known at some forces.
"""

import numpy as np

from cnnsim.support import Floats, InputError
from cnnsim.support.progress import watcher
from tactile.bump.body import Body
from tactile.bump.kinematics import PRESSED, SHEARED
from tactile.bump.law import Mixed
from tactile.bump.mesh import half_section
from tactile.bump.plate import plate_constraint, respond
from tactile.bump.probe import Probe
from tactile.bump.shape import Shape
from tactile.bump.table import Response
from tactile.bump.touch import lower
from tactile.elastic.medium import Medium

KNOTS = 9
"""Forces of a table of finite strain, with cubic splines in between."""
STEPS = 40
"""Steps in which the plate is lowered."""


def small_strain(shape: Shape, medium: Medium, depth: float, radii: Floats, fineness: float = 2.0) -> Response:
    """Return the linear response of a plate stuck to the bump up to ``shape.contact``, in the medium's quantity.

    Arguments: ``depth`` [m] under the body's surface, at most its thickness; ``radii`` (n,) [m], the first 0.

    Raises:
        InputError: taxels below the body's bottom or outside its sides.
    """
    points = _points(shape, depth, radii)
    mesh = half_section(shape, fineness)
    responses, stiffnesses = [], []
    for kinematics in (PRESSED, SHEARED):
        body = Body(mesh, kinematics, Mixed(medium))
        constraint = plate_constraint(body, shape, "press" if kinematics is PRESSED else "shift")
        state = respond(body, constraint)
        force = constraint.force(body.at_rest @ state)
        probe = Probe(body, points)
        read = probe.strain(state) if medium.quantity == "strain" else probe.stress(state)
        responses.append(read / force)
        stiffnesses.append(force)
    return Response(radii, np.ones(1), np.full(1, np.nan), *_five(*responses), np.array(stiffnesses))


def finite_strain(
    shape: Shape, medium: Medium, depth: float, radii: Floats, indentation: float, fineness: float = 1.0
) -> Response:
    """Return the response of neo-Hookean rubber under a flat plate that touches more and more of the bump.

    The normal part is the whole Green strain under the force; the shear part the change of Green strain per newton
    of a small shear force on top of it, the touched nodes sticking: exact to first order in the shear.

    Arguments: ``indentation`` [m], the largest; the others as ``small_strain``.

    Raises:
        InputError: as ``small_strain``; a medium that reads stress; an indentation that is not positive or too large.
    """
    if medium.quantity != "strain":
        raise InputError("a bump at finite strain whose taxels read stress; strain wanted")
    if not 0 < indentation < shape.radius:
        raise InputError(f"a bump of radius {shape.radius} m pressed in {indentation} m, less than the radius wanted")
    points = _points(shape, depth, radii)
    mesh = half_section(shape, fineness, touching=True)
    pressed, sheared = (Body(mesh, kinematics, Mixed(medium)) for kinematics in (PRESSED, SHEARED))
    probe, side_probe = Probe(pressed, points), Probe(sheared, points)
    stride = STEPS // (KNOTS - 1)
    forces, depths, normal, shear = [0.0], [0.0], [np.zeros((len(radii), 3, 3))], []
    stiffnesses, watched_by = np.zeros(2), watcher()
    for number, touch in enumerate(lower(pressed, shape, indentation * np.arange(1, STEPS + 1) / STEPS, True), 1):
        if watched_by is not None:
            watched_by(number / STEPS, f"bump pressed in {touch.indentation * 1e6:.3g} um")
        if number % stride and number != 1:
            continue
        gradient, pressure = pressed.at_points(touch.state)
        constraint = plate_constraint(sheared, shape, "shift", contact=touch.contact)
        state = respond(sheared, constraint, (gradient, pressure))
        force = constraint.force(sheared.stiffness(gradient, pressure) @ state)
        moved = sheared.at_points(state)[0] - np.eye(3)
        change = np.swapaxes(gradient, -1, -2) @ moved
        if number == 1:
            stiffnesses = np.array([touch.force / touch.indentation, force])
        shear.append(side_probe.read((change + np.swapaxes(change, -1, -2)) / 2) / force)
        if number % stride == 0:
            forces.append(touch.force)
            depths.append(touch.indentation)
            normal.append(probe.read((np.swapaxes(gradient, -1, -2) @ gradient - np.eye(3)) / 2))
    if watched_by is not None:
        watched_by.over()
    return Response(radii, np.array(forces), np.array(depths), *_five(np.array(normal), np.array(shear)), stiffnesses)


def _points(shape: Shape, depth: float, radii: Floats) -> Floats:
    if not 0 < depth <= shape.thickness:
        raise InputError(f"taxels {depth} m deep in a body of {shape.thickness} m, a depth up to it wanted")
    if radii.max() >= shape.reach:
        raise InputError(f"taxels {radii.max()} m from a bump whose body ends at {shape.reach} m, less wanted")
    within = depth * (1 - 1e-9)  # a point on the bottom may fall outside every element
    return np.stack([radii, np.full(len(radii), within)], axis=-1)


def _five(pressed: Floats, sheared: Floats) -> tuple[Floats, Floats]:
    """(N_zz, N_rz) and (S_zz, S_even, S_odd), with a first axis of forces, from tensors (..., n, 3, 3)."""
    along, around = sheared[..., 0, 2], sheared[..., 1, 2]
    normal = np.stack([pressed[..., 2, 2], pressed[..., 0, 2]], axis=-1)
    shear = np.stack([sheared[..., 2, 2], (along - around) / 2, -(along + around) / 2], axis=-1)
    normal[..., 0, 1] = 0  # odd functions are 0 on the axis
    shear[..., 0, [0, 2]] = 0
    return normal.reshape(-1, *normal.shape[-2:]), shear.reshape(-1, *shear.shape[-2:])
