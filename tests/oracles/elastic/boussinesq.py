"""The half-space under a point load, from its displacements: the reference for the closed forms.

Displacements: K. L. Johnson, Contact Mechanics (1985), eqs (3.18) and (3.75), for any Poisson's ratio. Their
gradient is taken by the complex step, which has no truncation error to speak of; stresses follow from
Hooke's law.
"""

import numpy as np
from numpy.typing import NDArray

STEP = 1e-60


def displacement(
    point: NDArray[np.complex128], load: tuple[float, float, float], shear_modulus: float, nu: float
) -> NDArray[np.complex128]:
    """(3,) displacement at ``point`` (3,), the load (Q, R, F) sitting at the origin."""
    x, y, z = point
    q, r, f = load
    d = np.sqrt(x * x + y * y + z * z)
    k = 1 - 2 * nu
    normal: NDArray[np.complex128] = np.array(
        [
            x * z / d**3 - k * x / (d * (d + z)),
            y * z / d**3 - k * y / (d * (d + z)),
            z * z / d**3 + 2 * (1 - nu) / d,
        ]
    )

    def along_first(a: complex, b: complex) -> tuple[complex, complex, complex]:
        """Displacement along the load, across it and down, for a unit tangential load along a."""
        return (
            1 / d + a * a / d**3 + k * (1 / (d + z) - a * a / (d * (d + z) ** 2)),
            a * b / d**3 - k * a * b / (d * (d + z) ** 2),
            a * z / d**3 + k * a / (d * (d + z)),
        )

    along, across, down = along_first(x, y)
    shear_x = np.array([along, across, down])
    along, across, down = along_first(y, x)
    shear_y = np.array([across, along, down])
    total: NDArray[np.complex128] = (f * normal + q * shear_x + r * shear_y) / (4 * np.pi * shear_modulus)
    return total


def strain_tensor(
    point: tuple[float, float, float], load: tuple[float, float, float], modulus: float, nu: float = 0.5
) -> NDArray[np.float64]:
    """(3, 3) symmetric gradient of the displacement."""
    gradient = np.empty((3, 3))
    for axis in range(3):
        nudged = np.array(point, dtype=complex)
        scale = float(np.linalg.norm(point))
        nudged[axis] += 1j * STEP * scale
        gradient[:, axis] = displacement(nudged, load, modulus / (2 * (1 + nu)), nu).imag / (STEP * scale)
    symmetric: NDArray[np.float64] = (gradient + gradient.T) / 2
    return symmetric


def stress_tensor(
    point: tuple[float, float, float], load: tuple[float, float, float], nu: float = 0.3
) -> NDArray[np.float64]:
    """(3, 3) stress by Hooke's law; its z row does not depend on ``nu``, so a compressible body serves."""
    modulus = 1.0
    strain = strain_tensor(point, load, modulus, nu)
    stress: NDArray[np.float64] = (modulus / (1 + nu)) * (strain + nu / (1 - 2 * nu) * np.trace(strain) * np.eye(3))
    return stress
