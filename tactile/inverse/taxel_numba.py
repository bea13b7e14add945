"""Taxel inverse, compiled: the operations of ``tactile.inverse.taxel`` in the same order, in blocks of cells.

The loops have no branches, so that LLVM vectorises them. Each block passes several short loops, since a processor
overlaps few cells of one long chain of roots and divisions. Intermediate values are in one small array, and no loop
writes more than two planes: LLVM cannot prove that four do not overlap.
"""

import math
from typing import Any

import numpy as np
from numba import get_num_threads, njit, prange

from cnnsim.support.compiled_loops import kept_helper, kept_njit
from tactile.inverse.validity import FAR, Validity

BLOCK = 256
"""Cells in a block: with 1024 cells ten million taxels take 1.5 times as long."""
X, Y, Z, LARGEST, ROOT, LENGTH = (row * BLOCK for row in range(6))
"""Rows of the intermediate array: the signals over the largest of them, that largest (-1: not finite), the root m, and
the factor of x and y (0: no answer)."""
WORK = 6 * BLOCK
SERIAL_BELOW = 8192
"""Number of cells from which threads pay."""

INSIDE, OUTSIDE = float(Validity.INSIDE), float(Validity.OUTSIDE)
AMBIGUOUS, INVALID = float(Validity.AMBIGUOUS), float(Validity.INVALID)


@njit(inline="always")
def _is_finite(value):  # type: ignore[no-untyped-def]  # numba types it at the call
    return value - value == 0


@njit(inline="always")
def _scaled(x, y, z, tiny, zero, one):  # type: ignore[no-untyped-def]
    finite = _is_finite(x) & _is_finite(y) & _is_finite(z)
    x = x if finite else zero
    y = y if finite else zero
    z = z if finite else zero
    largest = abs(x) if abs(x) > abs(y) else abs(y)
    largest = largest if largest > abs(z) else abs(z)
    some = largest >= tiny
    over = one / (largest if some else one)
    return x * over, y * over, z * over if some else -one, largest if some else zero, finite


@kept_helper(error_model="numpy")
def _scaled_block(x, y, z, work, tiny):  # type: ignore[no-untyped-def]
    zero, one = x.dtype.type(0), x.dtype.type(1)
    for i in range(x.size):
        work[i + X], work[i + Y], work[i + Z], largest, finite = _scaled(x[i], y[i], z[i], tiny, zero, one)
        work[i + LARGEST] = largest if finite else -one


@njit(inline="always")
def _intermediate(work, i, zero):  # type: ignore[no-untyped-def]
    largest = work[i + LARGEST]
    finite = largest >= zero
    return work[i + X], work[i + Y], work[i + Z], largest if finite else zero, finite


@njit(inline="always")
def _answer(work, i, length, force, region, possible, loaded, zero, invalid):  # type: ignore[no-untyped-def]
    answered = possible & loaded
    work[i + LENGTH] = length if answered else zero
    return force if answered else zero, (region if possible else invalid) if loaded else zero


@kept_helper(error_model="numpy")
def _roots(work, size):  # type: ignore[no-untyped-def]
    number = work.dtype.type
    three, eight, nine = number(3), number(8), number(9)
    for i in range(size):
        x, y, b = work[i + X], work[i + Y], abs(work[i + Z])
        work[i + ROOT] = three * b + math.sqrt(nine * b * b + eight * (x * x + y * y))


@kept_helper(error_model="numpy")
def _strain_block(work, force, validity, scale, depth, floor, pressing):  # type: ignore[no-untyped-def]
    number = work.dtype.type
    zero, one, two, three, four = number(0), number(1), number(2), number(3), number(4)
    far2 = number(FAR * FAR)
    in_code, out_code = number(INSIDE), number(OUTSIDE)
    unsure, invalid = number(AMBIGUOUS), number(INVALID)
    known = pressing != 0
    given = -one if pressing < 0 else one
    for i in range(force.size):
        x, y, z, largest, finite = _intermediate(work, i, zero)
        a2 = x * x + y * y
        b = abs(z)
        m = work[i + ROOT]
        straight = a2 <= far2 * b * b
        sign = -one if (not known) & straight & (z > zero) else given
        inside = sign * z < zero
        n = four if inside else m
        d = m if inside else two * (one if straight else a2)
        n2 = a2 * n * n
        d2 = d * d
        p = n2 + d2
        q = n2 + four * d2
        over = one / (d * q)
        over_d = q * over
        reach = n * over_d
        t = a2 * reach * reach
        size = (three * a2 * reach + abs(t - two) * b) * (p * math.sqrt(p) * over)
        size = sign * size * (scale * largest)
        possible = finite & (inside | (not straight)) & _is_finite(size)
        loaded = (not finite) | (largest > floor)
        region = in_code if inside else out_code
        region = region if known | straight else unsure
        length = sign * depth * reach
        force[i], validity[i] = _answer(work, i, length, size, region, possible, loaded, zero, invalid)


@kept_helper(error_model="numpy")
def _stress_block(work, force, validity, scale, depth, floor):  # type: ignore[no-untyped-def]
    number = work.dtype.type
    zero, one, two, far = number(0), number(1), number(2), number(FAR)
    in_code, out_code, invalid = number(INSIDE), number(OUTSIDE), number(INVALID)
    for i in range(force.size):
        x, y, z, largest, finite = _intermediate(work, i, zero)
        reachable = abs(z) > far
        over_z = one / (z if reachable else one)
        across = x * over_z
        along = y * over_z
        t = across * across + along * along
        size = (t + one) * (t + one) * math.sqrt(t + one) * -z
        size = size * (scale * largest)
        possible = finite & reachable & _is_finite(size)
        loaded = (not finite) | (largest > floor)
        region = in_code if t < two else out_code
        work[i + X], work[i + Y] = across, along
        force[i], validity[i] = _answer(work, i, -depth, size, region, possible, loaded, zero, invalid)


@kept_helper(error_model="numpy")
def _places(work, dx, dy):  # type: ignore[no-untyped-def]
    zero = work.dtype.type(0)
    for i in range(dx.size):
        length, x, y = work[i + LENGTH], work[i + X], work[i + Y]
        x, y = length * x, length * y  # before the choice, so that LLVM vectorises it
        dx[i] = x if length != zero else zero
        dy[i] = y if length != zero else zero


@kept_njit(error_model="numpy")
def strain_blocks(x, y, z, dx, dy, force, validity, first, last, numbers):  # type: ignore[no-untyped-def]
    """Write the load of the strain taxels of the blocks from ``first`` on, before ``last``; planes of one dimension."""
    work = np.empty(WORK, x.dtype)
    scale, tiny, depth, floor, pressing = numbers
    for start in range(first * BLOCK, min(last * BLOCK, x.size), BLOCK):
        cut = slice(start, min(start + BLOCK, x.size))
        _scaled_block(x[cut], y[cut], z[cut], work, tiny)
        _roots(work, cut.stop - cut.start)
        _strain_block(work, force[cut], validity[cut], scale, depth, floor, pressing)
        _places(work, dx[cut], dy[cut])


@kept_njit(error_model="numpy")
def stress_blocks(x, y, z, dx, dy, force, validity, first, last, numbers):  # type: ignore[no-untyped-def]
    """Write the load of the stress taxels of the blocks from ``first`` on, before ``last``; planes of one dimension."""
    work = np.empty(WORK, x.dtype)
    scale, tiny, depth, floor = numbers
    for start in range(first * BLOCK, min(last * BLOCK, x.size), BLOCK):
        cut = slice(start, min(start + BLOCK, x.size))
        _scaled_block(x[cut], y[cut], z[cut], work, tiny)
        _stress_block(work, force[cut], validity[cut], scale, depth, floor)
        _places(work, dx[cut], dy[cut])


@kept_helper(error_model="numpy")
def answers(values, strain, times, depth, floor):  # type: ignore[no-untyped-def]
    """Return the planes (families, 4, n) of the inverse of readings (rows, cols, 3), none if all are at most ``floor``.

    ``times``: 4 pi E z^2 / 3 for strain, 2 pi z^2 / 3 for stress.
    """
    rows, cols, _ = values.shape
    n, above = rows * cols, False
    signals = np.empty((3, n))
    for i in range(rows):
        for j in range(cols):
            for k in range(3):
                signals[k, i * cols + j] = values[i, j, k]
                above = above or not abs(values[i, j, k]) <= floor  # NaN is no quiet reading
    planes = np.empty(((2 if strain else 1) if above else 0, 4, n))
    blocks, tiny = -(-n // BLOCK), np.finfo(np.float64).tiny
    for f in range(len(planes)):
        out = planes[f]
        if strain:
            numbers = times, tiny, depth, floor, 1.0 - 2.0 * f
            strain_blocks(signals[0], signals[1], signals[2], out[0], out[1], out[2], out[3], 0, blocks, numbers)
        else:
            others = times, tiny, depth, floor
            stress_blocks(signals[0], signals[1], signals[2], out[0], out[1], out[2], out[3], 0, blocks, others)
    return planes


@kept_njit(parallel=True, error_model="numpy")
def _strain_parallel(x, y, z, dx, dy, force, validity, blocks, threads, numbers):  # type: ignore[no-untyped-def]
    for thread in prange(threads):
        first, last = thread * blocks // threads, (thread + 1) * blocks // threads
        strain_blocks(x, y, z, dx, dy, force, validity, first, last, numbers)


@kept_njit(parallel=True, error_model="numpy")
def _stress_parallel(x, y, z, dx, dy, force, validity, blocks, threads, numbers):  # type: ignore[no-untyped-def]
    for thread in prange(threads):
        first, last = thread * blocks // threads, (thread + 1) * blocks // threads
        stress_blocks(x, y, z, dx, dy, force, validity, first, last, numbers)


def strain_inverse(*arguments: Any) -> None:
    """Write the load of every strain taxel, as ``tactile.inverse.taxel.invert_strain`` returns it.

    Arguments: planes u_xz, u_yz, u_zz, dx, dy, force, validity, contiguous, of one dimension and one dtype (float32 or
    float64); depth, modulus, floor, pressing.
    """
    planes, (depth, modulus, floor, pressing) = arguments[:7], arguments[7:]
    number = planes[0].dtype.type
    scale = number(4 * np.pi / 3 * modulus * depth * depth)
    numbers = scale, np.finfo(number).tiny, number(depth), number(floor), number(pressing)
    _run(strain_blocks, _strain_parallel, planes, numbers)


def stress_inverse(*arguments: Any) -> None:
    """Write the load of every stress taxel, as ``tactile.inverse.taxel.invert_stress`` returns it.

    Arguments: planes s_xz, s_yz, s_zz and four results, as those of `strain_inverse`; depth, floor.
    """
    planes, (depth, floor) = arguments[:7], arguments[7:]
    number = planes[0].dtype.type
    numbers = number(2 * np.pi / 3 * depth * depth), np.finfo(number).tiny, number(depth), number(floor)
    _run(stress_blocks, _stress_parallel, planes, numbers)


def _run(blocks_of: Any, parallel: Any, planes: tuple[Any, ...], numbers: tuple[Any, ...]) -> None:
    blocks = -(-planes[0].size // BLOCK)
    if planes[0].size < SERIAL_BELOW:
        blocks_of(*planes, 0, blocks, numbers)
    else:
        parallel(*planes, blocks, get_num_threads(), numbers)
