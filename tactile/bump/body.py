"""Body of finite elements: out-of-balance forces and their derivative, with displacements alone or with pressures."""

from functools import cached_property

import numpy as np
from scipy import sparse
from scipy.sparse.linalg import splu
from skfem import Basis, ElementTriP1, ElementTriP2, ElementVector
from skfem.mesh import Mesh

from cnnsim.support import Floats, Integers
from tactile.bump.kinematics import Kinematics
from tactile.bump.law import Law, Mixed, stress, tangent

ELEMENTS = {1: ElementTriP1, 2: ElementTriP2}


class Body:
    """Displacements of degree 2 (or 1), with a ``Mixed`` law pressures of degree 1: Taylor and Hood's element.

    A state is one vector: displacements, then pressures. Errors are of the order h^3 in the displacement and h^2 in
    strain and pressure where the solution is smooth and curved sides are curved.

    Arguments: ``mesh`` of the section (x or radius, z); ``degree`` of the displacements.

    Source: Taylor and Hood (1973); Brezzi and Fortin, Mixed and Hybrid Finite Element Methods.
    """

    def __init__(self, mesh: Mesh, kinematics: Kinematics, law: Law, degree: int = 2) -> None:
        self.mesh, self.kinematics, self.law = mesh, kinematics, law
        kind = ELEMENTS[degree]
        self.basis = Basis(mesh, ElementVector(kind(), kinematics.components), intorder=4)
        self.size = int(self.basis.N)
        self.place = np.asarray(self.basis.doflocs)
        self.component = np.empty(self.size, np.int64)
        for number, index in enumerate(self.basis.split_indices()):
            self.component[index] = number
        where = np.asarray(self.basis.global_coordinates())
        self.weight = self.basis.dx * kinematics.around * (where[0] if kinematics.ring else 1.0)
        self.slopes = np.stack(
            [kinematics.gradient(np.asarray(field), field.grad, where[0]) for (field,) in self.basis.basis], axis=-1
        ).transpose(2, 3, 0, 1, 4)  # (elements, points, 3, 3, functions)
        self.slopes = self.slopes.reshape(*self.slopes.shape[:2], 9, -1)
        # G F and -G F^-T cancel at small deformation, to the rounding of G
        self.rounding = (
            np.finfo(float).eps
            * law.medium.shear_modulus
            * float((np.abs(self.slopes).sum((2, 3)) * self.weight).sum())
        )
        self.dofs: Integers = self.basis.element_dofs.T
        if law.mixed:
            line = ELEMENTS[1]
            self.pressures = Basis(mesh, line(), quadrature=self.basis.quadrature)
            self.shapes = np.stack([np.asarray(field) for (field,) in self.pressures.basis], axis=-1)
            self.dofs = np.hstack([self.dofs, self.pressures.element_dofs.T + self.size])
            self.size += int(self.pressures.N)
            self.place = np.hstack([self.place, self.pressures.doflocs])
            self.component = np.concatenate([self.component, np.full(self.pressures.N, -1)])

    def at_points(self, state: Floats) -> tuple[Floats, Floats]:
        """Return deformation gradients (elements, points, 3, 3) and pressures (elements, points) of a state."""
        local, count = state[self.dofs], self.slopes.shape[-1]
        gradient = np.einsum("eqcn,en->eqc", self.slopes, local[:, :count], optimize=True)
        gradient = gradient.reshape(*gradient.shape[:2], 3, 3) + np.eye(3)
        pressure = np.zeros(self.weight.shape)
        if self.law.mixed:
            pressure = np.einsum("eqn,en->eq", self.shapes, local[:, count:])
        return gradient, pressure

    def forces(self, state: Floats) -> Floats:
        """Return the out-of-balance forces [N], per metre in the plane; volumes [m^3] in the pressures' rows."""
        return self.both(*self.at_points(state))[0]

    def stiffness(self, gradient: Floats, pressure: Floats) -> sparse.csc_matrix:
        """Return the derivative of the forces by the state, at the gradients and pressures of ``at_points``."""
        return self.both(gradient, pressure)[1]

    @cached_property
    def at_rest(self) -> sparse.csc_matrix:
        """The ``stiffness`` without deformation: that of small strain."""
        return self.stiffness(*self.rest())

    def rest(self) -> tuple[Floats, Floats]:
        """Return ``at_points`` without deformation."""
        return np.broadcast_to(np.eye(3), (*self.weight.shape, 3, 3)), np.zeros(self.weight.shape)

    def both(self, gradient: Floats, pressure: Floats) -> tuple[Floats, sparse.csc_matrix]:
        """Return the out-of-balance forces and their derivative."""
        first, inverse, volume, s, m = stress(self.law, gradient, pressure)
        elements, points, _, count = self.slopes.shape
        weight = self.weight[..., None]
        tall = self.slopes.reshape(elements, points * 9, count).transpose(0, 2, 1)
        local = [np.matmul(tall, (first.reshape(elements, points, 9) * weight).reshape(elements, -1, 1))[..., 0]]
        cofactor = (np.swapaxes(inverse, -1, -2) * volume[..., None, None]).reshape(elements, points, 9, 1)
        if isinstance(self.law, Mixed):
            gap = (volume - 1 - self.law.compliance * pressure) * self.weight
            local.append(np.einsum("eqn,eq->en", self.shapes, gap))
        out = np.zeros(self.size)
        np.add.at(out, self.dofs, np.concatenate(local, axis=1))
        weighed = np.matmul(tangent(self.law, inverse, s, m) * weight[..., None], self.slopes)
        block = np.matmul(tall, weighed.reshape(elements, points * 9, count))
        if isinstance(self.law, Mixed):
            pushed = (cofactor * self.shapes[:, :, None, :] * weight[..., None]).reshape(elements, points * 9, -1)
            side = np.matmul(tall, pushed)
            shapes = self.shapes * weight
            corner = -self.law.compliance * np.einsum("eqn,eqm->enm", shapes, self.shapes)
            block = np.block([[block, side], [side.transpose(0, 2, 1), corner]])
        rows = np.broadcast_to(self.dofs[:, :, None], block.shape)
        cols = np.broadcast_to(self.dofs[:, None, :], block.shape)
        matrix = sparse.coo_matrix((block.ravel(), (rows.ravel(), cols.ravel())), (self.size, self.size))
        return out, matrix.tocsc()


def solve(matrix: sparse.csc_matrix, load: Floats, fixed: Integers, values: Floats) -> Floats:
    """Solve a linear body with some unknowns prescribed: direct, the matrix scaled to a diagonal near one."""
    state = np.zeros(matrix.shape[0])
    state[fixed] = values
    free = np.setdiff1d(np.arange(len(state)), fixed)
    right = (load - matrix @ state)[free]
    inner = matrix[free][:, free]
    scale = 1 / np.sqrt(np.maximum(abs(inner).max(axis=1).toarray().ravel(), np.finfo(float).tiny))
    by = sparse.diags(scale)
    factors = splu((by @ inner @ by).tocsc(), permc_spec="COLAMD")
    state[free] = scale * factors.solve(scale * right)
    return state
