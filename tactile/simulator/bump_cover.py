"""Cover with a bump over every taxel: loads act on bumps, and a matrix gives the readings."""

from dataclasses import dataclass, field
from typing import Any

import numpy as np
from scipy.interpolate import CubicSpline

from cnnsim.support import Floats, InputError
from cnnsim.support.extras import install_line
from cnnsim.support.terminal import echo
from tactile.bump.shape import Shape
from tactile.bump.table import Response, remembered
from tactile.core.frame import NORMAL, SHEAR_X, SHEAR_Y, TaxelArray
from tactile.core.loads import FORCE, X, Y
from tactile.elastic.halfspace import point_load
from tactile.elastic.medium import Medium
from tactile.simulator.contacts.loads import Loads

RADII = 257
"""Number of radii of a table, denser near the bump."""


@dataclass(frozen=True)
class Bumps:
    """Equal bumps over all taxels of a finger.

    ``shape``: their dimensions, of which ``reach`` is chosen for the array; ``nu``: Poisson's ratio; ``indentation``
    [m]: 0 for a linear body with the plate bonded to ``shape.contact``, else finite strains up to this indentation.

    Raises:
        InputError: a Poisson's ratio outside 0 .. 1/2, a negative indentation or one as large as the radius.
    """

    shape: Shape = field(default_factory=Shape)
    nu: float = 0.499
    indentation: float = 0.0
    memory: dict[Any, Any] = field(default_factory=dict, compare=False, repr=False)

    def __post_init__(self) -> None:
        Medium(1.0, self.nu)
        if not 0 <= self.indentation < self.shape.radius:
            raise InputError(
                f"indentation {self.indentation} m, from 0 to below the radius {self.shape.radius} m wanted"
            )

    def __str__(self) -> str:
        kind = f"finite strain to {self.indentation * 1e6:g} um" if self.indentation else "small strain"
        return f"bumps {self.shape.radius * 2e3:g} mm wide on {self.shape.thickness * 1e3:g} mm, nu {self.nu:g}, {kind}"

    def response(self, array: TaxelArray, quantity: str) -> Response:
        """The table for an array, at E = 1 Pa, computed once and kept in the user's cache.

        Raises:
            InputError: taxels below the body; as ``bump.response``.
        """
        at = array.positions().reshape(-1, 2)
        widest = float(np.linalg.norm(at[-1] - at[0]))
        # bodies of a few sizes only, so that arrays share tables; beyond 2 thicknesses a bonded body hardly deforms
        unit = 2 * self.shape.thickness + 5 * self.shape.radius
        reach = unit * 2.0 ** np.ceil(np.log2((widest + unit) / unit))
        shape = Shape(self.shape.radius, self.shape.thickness, reach, self.shape.contact, self.shape.fillet)
        radii = (reach - unit / 2) * np.linspace(0, 1, RADII) ** 2
        key = f"{shape} nu={self.nu!r} depth={array.depth!r} {quantity} indentation={self.indentation!r}"

        def make() -> Response:
            try:
                from tactile.bump.response import finite_strain, small_strain  # finite elements only where called for
            except ImportError as error:
                raise InputError(f"a bump needs finite elements: {install_line('fem')}") from error
            echo("bump: finite elements, once for these dimensions", err=True)
            medium = Medium(1.0, self.nu, "stress" if quantity == "stress" else "strain")
            if self.indentation:
                return finite_strain(shape, medium, array.depth, radii, self.indentation)
            return small_strain(shape, medium, array.depth, radii)

        return remembered(key, make)

    def over_flat(self, array: TaxelArray, quantity: str) -> float:
        """The force on the bump over a taxel, over the force that the inverse of the half-space gives.

        The inverse is linear in the normal reading. The ratio is therefore the reading of the half-space right under
        1 N over that of the bump. At finite strain it hardly depends on the force; the table's middle force is used.

        Raises:
            InputError: as ``response``.
        """
        table = self.response(array, quantity)
        middle = len(table.forces) // 2
        medium = Medium(1.0, quantity="stress" if quantity == "stress" else "strain")
        flat = point_load(np.zeros(2), array.depth, np.array([[0.0, 0.0, 0.0, 0.0, 1.0]]), medium)[2]
        return float(flat / (table.normal[middle, 0, 0] / table.forces[middle]))

    def readings(self, array: TaxelArray, medium: Medium, loads: Loads) -> Floats:
        """The readings (frames, rows, cols, 3) under all loads.

        A load acts on the four bumps around it with bilinear shares, which keep its force and moments; beyond the
        outermost bumps on the nearest ones. The shape of unloaded bumps is neglected.

        Raises:
            InputError: a twist; at finite strain, a bump that is pulled or pressed beyond its table.
        """
        if loads.twists:
            raise InputError("a twisted contact on bumps; forces alone wanted")
        key = array, medium
        if key not in self.memory:
            table = self.response(array, medium.quantity)
            self.memory[key] = table, _matrix(table, array)
        table, matrix = self.memory[key]
        forces = shared(np.concatenate([loads.with_patterns, *(disc.loads for disc in loads.discs)], axis=1), array)
        scale = 1.0 if medium.quantity == "stress" else 1 / medium.modulus
        features = forces * scale if table.linear else _features(forces, medium.modulus, table)
        out: Floats = features.reshape(len(features), -1) @ matrix
        return out.reshape(len(out), *array.shape, 3)


def shared(loads: Floats, array: TaxelArray) -> Floats:
    """Forces (frames, bumps, 3) on the bumps from rows (frames, n, 5)."""
    at = array.positions()[0, 0]
    cols, rows = (
        np.maximum(
            0, 1 - np.abs(np.clip((loads[..., k] - at[k]) / array.pitch, 0, count - 1)[..., None] - np.arange(count))
        )
        for k, count in ((X, array.cols), (Y, array.rows))
    )
    # (frames, n, cols * 3)
    pulled = (cols[..., None] * loads[..., None, FORCE]).reshape(*cols.shape[:2], array.cols * 3)
    return np.matmul(np.swapaxes(rows, 1, 2), pulled).reshape(len(loads), -1, 3)


def _matrix(table: Response, array: TaxelArray) -> Floats:
    """Rows (bump, force component, table force), columns (taxel, reading), at E = 1 Pa."""
    at = array.positions().reshape(-1, 2)
    apart = at[None] - at[:, None]  # from bump to taxel
    rho = np.linalg.norm(apart, axis=-1)
    c, s = np.moveaxis(apart / np.where(rho > 0, rho, 1)[..., None], -1, 0)
    c = np.where(rho > 0, c, 1.0)
    root = np.sqrt(table.radii)
    normal, rz = np.moveaxis(CubicSpline(root, table.normal, axis=1)(np.sqrt(rho)), -1, 0)  # (k, bumps, taxels)
    zz, even, odd = np.moveaxis(CubicSpline(root, table.shear, axis=1)(np.sqrt(rho)), -1, 0)
    rows = (
        (even - (2 * c * c - 1) * odd, -2 * c * s * odd, c * zz),
        (-2 * c * s * odd, even - (2 * s * s - 1) * odd, s * zz),
        (c * rz, s * rz, normal),
    )
    full = np.stack([np.stack(row, axis=-1) for row in rows])  # (force, k, bumps, taxels, reading)
    matrix: Floats = np.ascontiguousarray(full.transpose(2, 0, 1, 3, 4)).reshape(-1, at.shape[0] * 3)
    return matrix


def _features(forces: Floats, modulus: float, table: Response) -> Floats:
    """(frames, bumps, 3, k): shear forces over E and 1, times the weights of the table's forces, at E = 1 Pa."""
    normal = forces[..., NORMAL] / modulus
    deepest = table.forces[-1]
    if (normal > deepest).any() or (normal < 0).any():
        asked = f"{normal.min() * modulus:.4g} to {normal.max() * modulus:.4g} N"
        raise InputError(
            f"bumps under {asked}, 0 to {deepest * modulus:.4g} N wanted: the table of finite strain ends at "
            f"{table.indentations[-1] * 1e6:.4g} um"
        )
    weights = CubicSpline(table.forces, np.eye(len(table.forces)))(normal)
    weights[normal == 0] = np.eye(len(table.forces))[0]
    factors = np.stack([forces[..., SHEAR_X] / modulus, forces[..., SHEAR_Y] / modulus, np.ones_like(normal)], axis=-1)
    return factors[..., None] * weights[..., None, :]
