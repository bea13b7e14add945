"""A layer bonded to a rigid base, solved on a periodic grid: its waves from a system in z, contact and slip by descent.

Thickness and Young's modulus are 1. What presses must lie several thicknesses from its own images, which a bonded layer
does not feel. Nothing here comes from the product: neither potentials nor tables nor line weights.
"""

from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy import fft
from scipy.interpolate import CubicSpline
from scipy.linalg import expm

from cnnsim.support import Floats

DEEP = 18.0
"""k h from which a wave does not reach the base: exp(-36) is nothing."""
Complex = NDArray[np.complex128]


def system(k: Floats, nu: float) -> Floats:
    """Derivative in z of (U, W, S, N) under a wave exp(i k x): displacement (i U, W), sigma_xz = i S, sigma_zz = N.

    From Hooke's law and the two equations of equilibrium, written so that nu = 1/2 is a number like any other.
    """
    g, side, none = 1 / (2 * (1 + nu)), nu / (1 - nu), np.zeros_like(k)
    squeezed = (1 - 2 * nu) * (1 + nu) / (1 - nu)
    rows = [
        [none, -k, none + 1 / g, none],
        [side * k, none, none, none + squeezed],
        [2 * g / (1 - nu) * k * k, none, none, -side * k],
        [none, none, k, none],
    ]
    return np.moveaxis(np.array(rows), (0, 1), (-2, -1))


def _top(k: Floats, nu: float) -> Floats:
    """The state (n, 4, 2) on top under a unit S and a unit N there, U = W = 0 at the base."""
    through = expm(system(k, nu))
    felt = -np.linalg.solve(through[:, :2, :2], through[:, :2, 2:])
    return np.concatenate([felt, np.broadcast_to(np.eye(2), (len(k), 2, 2))], axis=1)


class PeriodicLayer:
    """``shape`` (rows, cols) cells of ``steps`` (along y, along x)."""

    def __init__(self, shape: tuple[int, int], steps: tuple[float, float], nu: float) -> None:
        self.shape, self.cell, self.nu = shape, steps[0] * steps[1], nu
        k_y = 2 * np.pi * fft.fftfreq(shape[0], steps[0])[:, None]
        k_x = 2 * np.pi * fft.rfftfreq(shape[1], steps[1])[None]
        self.k = np.hypot(k_x, k_y)
        some = np.where(self.k > 0, self.k, 1)
        self._c, self._s = np.where(self.k > 0, k_x, 1) / some, k_y / some
        self._known = np.concatenate([np.linspace(0, 1, 60)[:-1], np.linspace(1, DEEP, 400)])
        self._tops = _top(self._known, nu)
        slope = np.tanh(self._known) * 2 * (1 + nu)
        across = np.divide(slope, self._known, out=np.full_like(slope, 2 * (1 + nu)), where=self._known > 0)
        # W of p (N = -p), i U of q_s (S = i q), the shear across; beyond, all fall like 1 / k
        self._sinks = self._waves(-self._tops[:, 1, 1])
        self._along, self._across = self._waves(-self._tops[:, 0, 0]), self._waves(across)

    def _waves(self, known: Floats) -> Floats:
        near = CubicSpline(self._known, known)(np.minimum(self.k, DEEP))
        return np.asarray(near * np.minimum(1.0, DEEP / np.maximum(self.k, 1e-300)))

    def _back(self, waves: Any) -> Floats:
        return np.asarray(fft.irfft2(waves, s=self.shape))

    def sunk(self, pressure: Floats) -> Floats:
        """What the surface sinks in under a pressure (rows, cols)."""
        return self._back(fft.rfft2(pressure) * self._sinks)

    def dragged(self, shear: Floats) -> Floats:
        """By what the surface moves along x and y (2, rows, cols) under a traction (2, rows, cols)."""
        along, across = self._turned(shear)
        along, across = along * self._along, across * self._across
        return np.stack([
            self._back(self._c * along - self._s * across), self._back(self._s * along + self._c * across)
        ])  # fmt: skip

    def _turned(self, shear: Floats) -> tuple[Complex, Complex]:
        x, y = fft.rfft2(shear[0]), fft.rfft2(shear[1])
        return self._c * x + self._s * y, -self._s * x + self._c * y

    def strain(self, shear: Floats, pressure: Floats, depth: float) -> Floats:
        """(u_xz, u_yz, u_zz) at a depth (rows, cols, 3)."""
        nu, g = self.nu, 1 / (2 * (1 + self.nu))
        # beyond DEEP the wave is that of k h = DEEP, of a layer as many of its lengths thick
        beyond = DEEP * np.linspace(min(depth, 0.999), 1, 400)
        near = expm(system(self._known, nu) * depth) @ self._tops
        far = expm(system(np.full(len(beyond), DEEP), nu) * (beyond / DEEP)[:, None, None]) @ self._tops[-1]

        def read(take: Callable[[Floats, Floats], Floats]) -> Floats:
            inner = CubicSpline(self._known, take(near, self._known))(np.minimum(self.k, DEEP))
            outer = np.interp(self.k * depth, beyond, take(far, np.full(len(beyond), DEEP)), right=0.0)
            return np.where(self.k < DEEP, inner, outer)

        def zz(of: int) -> Floats:
            squeezed, side = (1 - 2 * nu) * (1 + nu) / (1 - nu), nu / (1 - nu)
            return read(lambda state, k: squeezed * state[:, 3, of] + side * k * state[:, 0, of])

        pressed, (along, across) = fft.rfft2(pressure), self._turned(shear)
        turned = np.cosh(self._known * (1 - depth)) / np.cosh(self._known)
        outer = np.interp(self.k * depth, beyond, np.cosh(DEEP - beyond) / np.cosh(DEEP), right=0.0)
        t_z = np.where(self.k < DEEP, CubicSpline(self._known, turned)(np.minimum(self.k, DEEP)), outer) * across
        s_z = 1j * (
            read(lambda state, _: state[:, 2, 1]) * pressed - 1j * read(lambda state, _: state[:, 2, 0]) * along
        )
        waves = -s_z * self._c + t_z * self._s, -s_z * self._s - t_z * self._c
        z_z = -zz(1) * pressed + 1j * zz(0) * along
        return np.stack([self._back(waves[0]) / (2 * g), self._back(waves[1]) / (2 * g), self._back(z_z)], axis=-1)

    def pressed(self, gap: Floats, indentation: float, tolerance: float = 1e-5) -> Floats:
        """Pressures under a rigid body whose underside lies a gap (rows, cols) over the surface, sunk in by so much."""
        pressure = way = np.zeros(self.shape)
        last, touching = 1.0, np.zeros(self.shape, bool)
        for _ in range(3000):
            left = indentation - gap - self.sunk(pressure)
            now = (pressure > 0) | (left > 0)
            rest = np.where(now, left, 0.0)
            if np.abs(rest).max() < tolerance * indentation:
                return pressure
            size = float((rest**2).sum())
            way = rest if (now != touching).any() else rest + size / last * way
            last, touching = size, now
            along = np.where(now, self.sunk(way), 0.0)
            pressure = np.maximum(pressure + float((rest * way).sum()) / float((way * along).sum()) * way, 0.0)
        raise AssertionError("no pressures found")

    def slipped(self, most: Floats, way: Floats, tolerance: float = 1e-7) -> Floats:
        """Tractions (2, rows, cols) of at most ``most`` when what touches is moved by a way (2, rows, cols).

        Where less is needed the surface goes with it; elsewhere it slips and pulls against the slip: the least of
        q . G q / 2 - q . way over |q| <= most, by projected descent with Nesterov's steps. After slips in the past the
        way is that of the body less these.
        """
        step = 1 / max(self._along.max(), self._across.max())
        shear = ahead = np.zeros((2, *self.shape))
        swing = 1.0
        for _ in range(4000):
            new = ahead + step * (way - self.dragged(ahead))
            new = new * np.minimum(1, most / np.maximum(np.hypot(*new), 1e-300))
            if ((ahead - new) * (new - shear)).sum() > 0:
                swing = 1.0
            after = (1 + np.sqrt(1 + 4 * swing**2)) / 2
            ahead = new + (swing - 1) / after * (new - shear)
            change = np.abs(new - shear).max()
            shear, swing = new, after
            if change < tolerance * most.max():
                return shear
        raise AssertionError("no tractions found")
