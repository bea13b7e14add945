"""Probe of displacement, strain and stress at points of a body, smoothed over the elements."""

from functools import cached_property

import numpy as np
from scipy.sparse.linalg import splu
from skfem import Basis, MeshTri
from skfem.models.poisson import mass

from cnnsim.support import Floats
from tactile.bump.body import ELEMENTS, Body


class Probe:
    """Points (n, 2) of the section at which states are read.

    Strains jump from element to element; they are read from the continuous quadratic field that fits them best
    in the mean square, which is more accurate than either side of a jump.
    """

    def __init__(self, body: Body, points: Floats) -> None:
        self.body = body
        at = np.ascontiguousarray(np.asarray(points, dtype=np.float64).T)
        mesh, mapping = body.mesh, body.basis.mapping
        # curved meshes have no finder; inside, they are all but straight
        corners = np.ascontiguousarray(mesh.p[:, : mesh.nvertices]), np.ascontiguousarray(mesh.t)
        self._cells = MeshTri(*corners).element_finder()(*at)
        self._local = mapping.invF(at[:, :, None], tind=self._cells)
        self._scalar = Basis(mesh, ELEMENTS[2](), quadrature=body.basis.quadrature)

    def _shapes(self, basis: Basis) -> tuple[Floats, Floats]:
        """Return values (functions, ..., n) and unknowns (functions, n) of a basis at the points."""
        fields = [
            np.asarray(basis.elem.gbasis(basis.mapping, self._local, number, tind=self._cells)[0])[..., 0]
            for number in range(basis.Nbfun)
        ]
        return np.stack(fields), basis.element_dofs[:, self._cells]

    def displacement(self, state: Floats) -> Floats:
        """Return the displacement (n, components) [m]."""
        shapes, dofs = self._shapes(self.body.basis)
        return np.einsum("fcn,fn->nc", shapes, state[dofs])

    @cached_property
    def _nearest(self) -> splu:
        return splu(mass.assemble(self._scalar).tocsc())

    def read(self, field: Floats) -> Floats:
        """Return a field (elements, quadrature points, ...) at the points: (n, ...)."""
        basis = self._scalar
        weight = np.stack([np.asarray(shape) for (shape,) in basis.basis]) * basis.dx
        flat = field.reshape(*field.shape[:2], -1)
        right = np.zeros((basis.N, flat.shape[-1]))
        np.add.at(right, basis.element_dofs, np.einsum("feq,eqk->fek", weight, flat, optimize=True))
        nodal = self._nearest.solve(right)
        shapes, dofs = self._shapes(basis)
        return np.einsum("fn,fnk->nk", shapes, nodal[dofs]).reshape(-1, *field.shape[2:])

    def strain(self, state: Floats) -> Floats:
        """Return the small strain (n, 3, 3), the symmetric part of the displacement's gradient."""
        gradient, _ = self.body.at_points(state)
        return self.read((gradient + np.swapaxes(gradient, -1, -2)) / 2 - np.eye(3))

    def stress(self, state: Floats) -> Floats:
        """Return the stress at small strain (n, 3, 3) [Pa], 2 G e + p, of a mixed body."""
        gradient, pressure = self.body.at_points(state)
        strain = (gradient + np.swapaxes(gradient, -1, -2)) / 2 - np.eye(3)
        return self.read(2 * self.body.law.medium.shear_modulus * strain + pressure[..., None, None] * np.eye(3))
