"""A quarter of the bump as a solid, the rotated half section: the reference for the body of revolution."""

import itertools

import numpy as np
from skfem import MeshTet, MeshTet2

from cnnsim.support import Floats, Integers
from tactile.bump.mesh import onto_arc, plane_mesh
from tactile.bump.shape import Shape

FIRST = np.array(
    [
        (0, 1, 2, 3, 4, 5),
        (1, 2, 0, 4, 5, 3),
        (2, 0, 1, 5, 3, 4),
        (3, 5, 4, 0, 2, 1),
        (4, 3, 5, 1, 0, 2),
        (5, 4, 3, 2, 1, 0),
    ]
)
"""How a prism is turned so that a vertex comes first."""


def quarter_solid(shape: Shape, fineness: float, sectors: int) -> MeshTet2:
    """Tetrahedra with curved edges in the quarter x, y >= 0: the half section turned in ``sectors`` steps.

    Every triangle becomes a prism a sector, cut into three tetrahedra along the diagonals from the smallest vertex
    number, so that neighbours agree. Source: Dompierre, Labbe, Vallet, Camarero (1999).
    """
    flat = plane_mesh(shape, fineness)
    axis = np.flatnonzero(flat.p[0] == 0)
    off = np.flatnonzero(flat.p[0] > 0)
    number = np.empty((sectors + 1, flat.p.shape[1]), np.int64)
    number[:, axis] = np.arange(axis.size)  # the axis turns into itself
    number[:, off] = axis.size + np.arange((sectors + 1) * off.size).reshape(sectors + 1, -1)
    angle = np.linspace(0, np.pi / 2, sectors + 1)
    points = np.empty((3, int(number.max()) + 1))
    for ring, turn in zip(number, angle, strict=True):
        points[:, ring] = flat.p[0] * np.cos(turn), flat.p[0] * np.sin(turn), flat.p[1]
    points[0, number[-1, off]] = 0.0  # cos(pi / 2) is not quite
    prisms = np.concatenate(
        [np.concatenate([low[flat.t], up[flat.t]]) for low, up in itertools.pairwise(number)], axis=1
    )
    mesh = MeshTet(points, _tetrahedra(prisms))
    fine = MeshTet2.from_mesh(mesh)
    doflocs, middle = np.array(fine.doflocs, order="C"), mesh.p.shape[1] + np.arange(mesh.edges.shape[1])
    ends = mesh.p[:, mesh.edges]  # (3, 2, edges)
    radius, z = np.hypot(ends[0], ends[1]), ends[2]
    turn = np.arctan2(ends[1], ends[0])
    turn = np.where(radius > 0, turn, turn[::-1])  # an end on the axis has the other's angle
    doflocs[:, middle] = _turned(radius.mean(0), turn.mean(0), z.mean(0))
    section = np.stack([np.hypot(doflocs[0], doflocs[1]), doflocs[2]])
    flat_ends = np.stack([np.hypot(mesh.p[0], mesh.p[1]), mesh.p[2]])
    onto_arc(section, middle, flat_ends, mesh.edges, shape)
    doflocs[:, middle] = _turned(section[0, middle], turn.mean(0), section[1, middle])
    return MeshTet2(np.ascontiguousarray(doflocs), np.ascontiguousarray(fine.t))


def _turned(radius: Floats, turn: Floats, z: Floats) -> Floats:
    # the planes x = 0 and y = 0 exactly
    return np.stack([np.where(turn > 1.5707, 0, radius * np.cos(turn)), radius * np.sin(turn), z])


def _tetrahedra(prisms: Integers) -> Integers:
    """(4, m) from prisms (6, n), vertex k + 3 above vertex k; edges along the axis have no height."""
    first = np.argmin(prisms, axis=0)
    v = np.take_along_axis(prisms, FIRST[first].T, axis=0)
    rising = np.minimum(v[1], v[5]) < np.minimum(v[2], v[4])
    cuts = (((0, 1, 2, 5), (0, 1, 5, 4), (0, 4, 5, 3)), ((0, 1, 2, 4), (0, 4, 2, 5), (0, 4, 5, 3)))
    parts = [v[list(cut)][:, rising == (kind == 0)] for kind, three in enumerate(cuts) for cut in three]
    elements = np.concatenate(parts, axis=1)
    ordered = np.sort(elements, axis=0)
    return elements[:, (np.diff(ordered, axis=0) > 0).all(axis=0)]
