"""Hard cases of located loads: taxels in a line, loads under a taxel, pulling loads, two at once, broken signals."""

from collections.abc import Sequence
from functools import partial
from typing import Any

import numpy as np

from cnnsim.backends.base import Backend
from cnnsim.support import Array, Floats
from tactile.inverse.localise import localise
from tactile.inverse.taxel import STRAIN_INVERSE, invert_strain
from tests.hard_cases.case import HardCase
from tests.kits.touch.pads import DEPTH, MODULUS, array, measured

SCALE = np.array([DEPTH, DEPTH, 1.0, 1.0, 1.0])


def _located(at: Floats, strain: Floats, backend: Backend) -> Any:
    planes = tuple(backend.load(np.ascontiguousarray(one, backend.dtype), "lam") for one in np.moveaxis(strain, -1, 0))
    answers = [backend.cellwise(STRAIN_INVERSE, planes, (DEPTH, MODULUS, 0.0, sign)) for sign in (1.0, -1.0)]
    pressing, pulling = (tuple(np.asarray(backend.read(one), np.float64) for one in family) for family in answers)
    return localise(at, pressing, pulling, DEPTH)


def _first(at: Floats, strain: Floats, columns: Sequence[int], backend: Backend) -> Array:
    load = _located(at, strain, backend)
    return np.array([load.x, load.y, load.Q, load.R, load.F])[list(columns)] / SCALE[list(columns)]


def _case(
    name: str, why: str, at: Floats, load: Sequence[float], naive: Any, *, columns: Sequence[int] = range(5),
    strain: Any = None, **more: Any,
) -> HardCase:  # fmt: skip
    """``naive`` takes places, signals and columns; ``strain``: signals instead of those of the load."""
    given = measured(at, [np.array(load)], False)
    exact, form = (np.array(load) / SCALE)[list(columns)], naive and partial(naive, at, given, columns)
    ours = partial(_first, at, given if strain is None else strain, columns)
    return HardCase(name, why, ours, lambda: exact, 1e-8, 2e-3, form, **more)


def _cramer(at: Floats, strain: Floats, columns: Sequence[int]) -> Array:
    """Places from each taxel's own answer, forces by Cramer's rule for three taxels, eq. (14)."""
    x, y, z = np.moveaxis(strain, -1, 0)
    dx, dy, force, _ = invert_strain(x, y, z, DEPTH, MODULUS, 0.0, 1)
    places = at.reshape(-1, 2)[:3] + np.stack([dx.ravel()[:3], dy.ravel()[:3]], axis=-1)
    place = places.mean(axis=0)
    seen = np.column_stack([at.reshape(-1, 2)[:3] - place, np.full(3, DEPTH)])
    minors = np.linalg.det(seen)
    forces = [
        np.linalg.det(np.where(np.arange(3) == k, (force.ravel()[:3] * DEPTH)[:, None], seen)) / minors
        for k in range(3)
    ]
    return (np.array([*place, *forces]) / SCALE)[list(columns)]


def _pressing(at: Floats, strain: Floats, columns: Sequence[int]) -> Array:
    """The strongest taxel's answer under the assumption that the load presses."""
    x, y, z = np.moveaxis(strain, -1, 0)
    dx, dy, force, _ = invert_strain(x, y, z, DEPTH, MODULUS, 0.0, 1)
    best = np.unravel_index(np.abs(strain).max(axis=-1).argmax(), z.shape)
    return (np.array([*(at[best] + [dx[best], dy[best]]), 0.0, 0.0, force[best]]) / SCALE)[list(columns)]


def _azimuth(at: Floats, strain: Floats, columns: Sequence[int]) -> Array:
    """The strongest taxel's answer with tan(alpha) = u_yz / u_xz, eq. (2)."""
    x, y, z = strain[np.unravel_index(np.abs(strain[..., 2]).argmax(), strain.shape[:2])]
    t = 8 * (x * x + y * y) / (9 * z * z)
    cosine = 1 / np.sqrt(1 + (y / x) ** 2)
    return np.full(len(columns), np.sqrt(t) * cosine)


def _two(backend: Backend) -> Array:
    load = _located(PAD, measured(PAD, TWO, False), backend)
    rows = [(one.x, one.y, one.Q, one.R, one.F) for one in (load, *load.others)]
    return np.array(sorted(rows)) / SCALE if len(rows) == 2 else np.full((2, 5), np.nan)


def _mean_of_two() -> Array:
    """One load: the mean of the answers of all taxels, weighted by their signals."""
    x, y, z = np.moveaxis(measured(PAD, TWO, False), -1, 0)
    dx, dy, force, _ = invert_strain(x, y, z, DEPTH, MODULUS, 0.0, 1)
    weight = np.abs(z) / np.abs(z).sum()
    one = np.array(
        [(weight * (PAD[..., 0] + dx)).sum(), (weight * (PAD[..., 1] + dy)).sum(), 0, 0, (weight * force).sum()]
    )
    return np.stack([one, one]) / SCALE


def _broken(value: float) -> Floats:
    strain = measured(SQUARE, [np.array(ABOVE)], False)
    strain[0, 0] = value
    return strain


LINE, SQUARE, PAD = array(1, 3), array(3, 3), array(8, 8)
BENT = LINE + np.array([[[0, 0], [0, 1e-9], [0, 0]]])
ABOVE = [4.3e-3, -2.4e-3, 0.05, -0.04, 0.4]
ON_LINE = [4.3e-3, float(LINE[0, 0, 1]), 0.05, 0.0, 0.4]
UNDER = [*SQUARE[1, 1].tolist(), 0.0, 0.0, 0.4]
PULL = [4.3e-3, -2.4e-3, 0.0, 0.0, -0.4]
TURNED = [4.3e-3, -2.4e-3, 0.9, -0.7, 0.1]
TWO = np.array([
    [*(PAD[1, 1] + [2e-4, 1e-4]).tolist(), 0.02, 0.0, 0.3], [*(PAD[6, 6] - [1e-4, 3e-4]).tolist(), 0.0, 0.03, 0.2],
])  # fmt: skip
ALONG = (0, 2, 4)
NOT_THERE = "the mean of the taxels' answers is a load that does not exist"

CASES = [
    _case("three taxels in a line", "the determinant of eq. (14) is 0", LINE, ON_LINE, _cramer, columns=ALONG),
    _case(
        "three taxels, 1 nm off a line", "the shear along the line is determined as well as on a line", BENT,
        ON_LINE, _cramer, columns=ALONG, naive_fails=False,
    ),
    _case("a load right under a taxel", "that taxel's azimuth is 0/0", SQUARE, UNDER, _azimuth),
    _case("a load that pulls", "azimuth and region are the reverse of those of a push", SQUARE, PULL, _pressing),
    _case("shear that turns the sign", "some taxels measure a push, others a pull", SQUARE, TURNED, _pressing),
    HardCase("two loads at once", NOT_THERE, _two, lambda: TWO / SCALE, 1e-6, 5e-2, _mean_of_two),
    *(
        _case(f"{value} in a taxel", "it must be ignored and not spread", SQUARE, ABOVE, None, strain=_broken(value))
        for value in (float("nan"), float("inf"))
    ),
]  # fmt: skip
