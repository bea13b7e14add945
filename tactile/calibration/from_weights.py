"""Calibration from known loads, one after the other: gains or a cross-axis matrix of every taxel, by least squares."""

from typing import Literal, NamedTuple

import numpy as np

from cnnsim.support import Floats, InputError
from tactile.calibration.taxel_gains import TaxelGains
from tactile.core.frame import TaxelArray
from tactile.elastic.halfspace import point_load_strain, point_load_stress

Model = Literal["matrix", "gains", "common"]
"""A 3 x 3 matrix of every taxel, three gains of every taxel, one matrix for all."""
SURE = 5.0
"""Least ratio of a gain to its standard deviation."""
NAMES = "x", "y", "normal"


class KnownLoads(NamedTuple):
    """Known loads, one after the other: ``forces`` (n, 3) Q, R, F [N]; ``places`` (n, 2) [m], or None.

    Readings of force taxels add up to the load wherever it is; those of strain and stress depend on its place.
    """

    forces: Floats
    places: Floats | None


def calibrate_loads(
    readings: Floats, loads: KnownLoads, array: TaxelArray, modulus: float | None, model: Model
) -> TaxelGains:
    """Return the gains that convert the readings under known loads to the quantity of these loads.

    Force:            sum over the taxels of M_n r_n = (Q, R, F)
    Strain, stress:   r_n = M_n^-1 u_n, that of the half-space under the load (eqs (1), (10))

    each by least squares over the loads, component by component, with deviations from the residuals. Strain and
    stress of every taxel are known, so noise of the readings causes no bias; of forces only the sum is known, and
    noise reduces the gains by its part of the readings' mean square. ``model``: M free, diagonal, or free and the same
    for all taxels.

    Arguments: ``readings`` (n, rows, cols, 3) less their tare under each load; ``modulus`` E [Pa] of a strain array.

    Raises:
        InputError: shapes that do not match, too few loads, a load without a place where one is wanted, a gain
            that the loads do not determine.
    """
    rows, cols = array.shape
    if readings.shape[1:] != (rows, cols, 3) or loads.forces.shape != (len(readings), 3):
        raise InputError(
            f"readings {readings.shape} and forces {loads.forces.shape}, (n, {rows}, {cols}, 3) and (n, 3) wanted"
        )
    if not (np.isfinite(readings).all() and np.isfinite(loads.forces).all()):
        raise InputError("readings or loads that are not finite, finite ones wanted")
    taxels = rows * cols
    read = readings.reshape(-1, taxels, 3)
    if array.quantity == "force":
        matrix, sigma = _of_forces(read, loads.forces, model)
    elif model == "common":
        signals = _signals(loads, array, modulus)
        same = _of_taxel(read.reshape(-1, 3), signals.reshape(-1, 3), model, "")
        matrix, sigma = (np.repeat(part[None], taxels, axis=0) for part in same)
    else:
        signals = _signals(loads, array, modulus)
        each = [_of_taxel(read[:, n], signals[:, n], model, f"taxel {divmod(n, cols)}: ") for n in range(taxels)]
        matrix, sigma = (np.array([one[part] for one in each]) for part in (0, 1))
    for n, axis in np.ndindex(taxels, 3):
        gain, error = matrix[n, axis, axis], sigma[n, axis, axis]
        if not abs(gain) > SURE * error:
            raise InputError(
                f"taxel {divmod(n, cols)}: {NAMES[axis]} gain {gain:.3g} +- {error:.3g}: the loads do not determine it;"
                " loads on it along that axis, or a simpler model wanted"
            )
    shape = rows, cols, 3, 3
    return TaxelGains(matrix.reshape(shape), sigma.reshape(shape), array.quantity)


def _of_forces(read: Floats, forces: Floats, model: Model) -> tuple[Floats, Floats]:
    """Return the matrices (taxels, 3, 3) whose sum over readings (n, taxels, 3) is the force (n, 3), and deviations."""
    matrix, sigma = np.zeros((read.shape[1], 3, 3)), np.zeros((read.shape[1], 3, 3))
    for axis in range(3):
        used = [axis] if model == "gains" else [0, 1, 2]
        parts = read[..., used].sum(axis=1) if model == "common" else read[..., used].reshape(len(read), -1)
        found, error = _solved(parts, forces[:, axis], NAMES[axis])
        matrix[:, axis, used], sigma[:, axis, used] = (part.reshape(-1, len(used)) for part in (found, error))
    return matrix, sigma


def _of_taxel(read: Floats, signals: Floats, model: Model, taxel: str) -> tuple[Floats, Floats]:
    """Return the matrix (3, 3) from readings (n, 3) to signals (n, 3), and its deviations.

    The readings are fitted to the signals, which are known: r = K u, M = K^-1, dM = -M dK M.
    """
    made, error = np.zeros((3, 3)), np.zeros((3, 3))
    for axis in range(3):
        used = [axis] if model == "gains" else [0, 1, 2]
        made[axis, used], error[axis, used] = _solved(signals[:, used], read[:, axis], taxel + NAMES[axis])
    try:
        matrix = np.asarray(np.linalg.inv(made), np.float64)
    except np.linalg.LinAlgError:
        raise InputError(f"{taxel}readings over the signals {made.tolist()}: a taxel without a reading") from None
    if model == "gains":
        return matrix, matrix**2 * error
    spread = np.linalg.inv(signals.T @ signals)  # covariance of a row of K for residuals of variance 1
    residual = error[:, 0] ** 2 / spread[0, 0]
    variance: Floats = np.outer(matrix**2 @ residual, np.einsum("jb,jk,kb->b", matrix, spread, matrix))
    return matrix, np.sqrt(variance)


def _signals(loads: KnownLoads, array: TaxelArray, modulus: float | None) -> Floats:
    """Return the signals (n, taxels, 3) of the loads by eqs (1), (10)."""
    if loads.places is None:
        raise InputError(f"loads without a place for taxel array {array.name!r} of {array.quantity}; x and y wanted")
    rows = np.concatenate([loads.places, loads.forces], axis=1)[:, None]
    at = array.positions().reshape(-1, 2)
    if array.quantity == "stress":
        return np.array([point_load_stress(at, array.depth, row) for row in rows])
    if modulus is None:
        raise InputError(f"taxel array {array.name!r} of strain without a Young's modulus, a known one wanted")
    return np.array([point_load_strain(at, array.depth, row, modulus) for row in rows])


def _solved(parts: Floats, wanted: Floats, name: str) -> tuple[Floats, Floats]:
    """Return the coefficients of the parts (n, k) that give ``wanted`` (n,), and their standard deviations."""
    loads, unknown = parts.shape
    if loads <= unknown:
        raise InputError(f"{name}: {loads} loads for {unknown} coefficients; at least {unknown + 1} wanted")
    unit = np.abs(parts).max(axis=0)
    unit[unit == 0] = 1.0
    found, _, rank, singular = np.linalg.lstsq(parts / unit, wanted, rcond=1e-9)
    if rank < unknown:
        raise InputError(
            f"{name}: the loads determine {rank} of {unknown} coefficients; loads on every taxel along every axis,"
            " in varying proportions, or a simpler model wanted"
        )
    residual = wanted - parts / unit @ found
    spread = np.linalg.inv((parts / unit).T @ (parts / unit)) if singular[-1] > 0 else np.full((unknown,) * 2, np.inf)
    error = np.sqrt(float(residual @ residual) / (loads - unknown) * np.diag(spread))
    return found / unit, error / unit
