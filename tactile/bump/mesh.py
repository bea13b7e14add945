"""Meshes of the bump's half section and whole section."""

from functools import partial

import numpy as np
from skfem import MeshTri, MeshTri2

from tactile.bump.shape import Shape
from tactile.bump.triangulate import triangulate


def half_section(shape: Shape, fineness: float = 1.0, touching: bool = False, sensor: float | None = None) -> MeshTri2:
    """Return triangles with curved sides on the half x >= 0 of the section: ``fineness`` 2 halves their edges."""
    return curved(plane_mesh(shape, fineness, touching, sensor), shape)


def plane_mesh(shape: Shape, fineness: float = 1.0, touching: bool = False, sensor: float | None = None) -> MeshTri:
    """Return the triangles of `half_section` with straight sides."""
    size = partial(shape.size, fineness=fineness, touching=touching, sensor=sensor)
    points, triangles = triangulate(shape.outline(), shape.inside, size)
    return MeshTri(np.ascontiguousarray(points.T), np.ascontiguousarray(triangles.T))


def whole_section(shape: Shape, fineness: float = 1.0, touching: bool = False, sensor: float | None = None) -> MeshTri2:
    """Return the half section and its mirror image, exactly symmetric, so that any cross-talk is the solver's."""
    half = plane_mesh(shape, fineness, touching, sensor)
    count, p = half.p.shape[1], half.p
    off = np.flatnonzero(p[0] > 0)
    number = np.arange(count)
    number[off] = count + np.arange(off.size)
    points = np.concatenate([p, p[:, off] * [[-1], [1]]], axis=1)
    return curved(MeshTri(points, np.concatenate([half.t, number[half.t]], axis=1)), shape)


def curved(mesh: MeshTri, shape: Shape) -> MeshTri2:
    """Return the mesh with the midpoints of its arc sides on the arc: straight sides reduce the order of P2."""
    fine = MeshTri2.from_mesh(mesh)
    doflocs = np.array(fine.doflocs, order="C")
    middle = mesh.p.shape[1] + np.arange(mesh.facets.shape[1])
    at = middle[shape.curved(mesh.p.T)[mesh.facets].all(axis=0)]  # of sides both ends of which lie on the arc
    doflocs[:, at] *= shape.radius / np.linalg.norm(doflocs[:, at], axis=0)
    return MeshTri2(np.ascontiguousarray(doflocs), np.ascontiguousarray(fine.t))
