"""Viscoelasticity: a Prony series between the elastic field and the readings."""

from collections.abc import Iterable, Iterator
from dataclasses import replace

import numpy as np

from cnnsim.support import InputError
from cnnsim.support.compiled_loops import kept_njit
from tactile.simulator.batch import Batch
from tactile.simulator.effect import effect, parameter


@effect("frames")
class Viscoelastic:
    """Relaxation y = x - sum of g_i (x - h_i), or creep y = x + the same sum.

    h_i(t) is the integral of exp(-(t - s) / tau_i) dx(s).

    A step of the elastic reading x gives y = 1 - sum of g_i (1 - exp(-t / tau_i)): the force relaxes under a constant
    indentation. ``creep`` turns the sign: strain grows under a constant force. For x linear between frames the
    recursion is exact for any interval,

        h_i <- exp(-dt / tau_i) h_i + (1 - exp(-dt / tau_i)) tau_i / dt * dx.

    Arguments: ``parts`` ((g_i, tau_i), ...), tau in [s]. Before the first frame x is 0.

    Raises:
        InputError: a g below 0, their sum above 1 in relaxation, a tau that is not positive.

    Source: Prony series of linear viscoelasticity; Taylor, Pister, Goudreau (1970) for the recursion.
    """

    parts: tuple[tuple[float, float], ...] = parameter(((0.04, 0.1), (0.04, 2.0)), none=())
    creep: bool = parameter(False)

    def __post_init__(self) -> None:
        try:
            pairs = tuple((float(g), float(tau)) for g, tau in self.parts)
        except (TypeError, ValueError) as error:
            raise InputError(f"parts = {self.parts!r}, a list of [share, time] pairs wanted") from error
        object.__setattr__(self, "parts", pairs)  # a file gives lists
        total = sum(g for g, _ in pairs)
        if not all(g >= 0 and 0 < tau < np.inf for g, tau in pairs) or not (
            total <= 1 or (self.creep and total < np.inf)
        ):
            raise InputError(f"parts = {pairs}, shares from 0 up with a sum of at most 1 and positive times wanted")

    def __call__(self, stream: Iterable[Batch], random: np.random.Generator) -> Iterator[Batch]:
        """Frames with relaxation or creep."""
        shares, times = np.array(self.parts).T
        shares = -shares if self.creep else shares
        before, inner, last = np.zeros(0), np.zeros((0, 0)), 0.0
        for batch in stream:
            flat = batch.flat
            if not inner.size and len(flat):
                before, inner = np.zeros(flat.shape[1]), np.zeros((len(times), flat.shape[1]))
                last = float(batch.t[0])
            steps = np.maximum(np.diff(batch.t, prepend=last), 0)[:, None] / times
            keep = np.exp(-steps)
            take = np.where(steps > 0, -np.expm1(-steps) / np.where(steps > 0, steps, 1), 1.0)
            out = np.empty_like(flat)
            recur(flat, before, inner, keep, take, shares, out)
            last = float(batch.t[-1]) if len(batch.t) else last
            yield replace(batch, values=out.reshape(batch.values.shape))


@kept_njit()
def recur(x, before, inner, keep, take, shares, out):  # type: ignore[no-untyped-def]  # numba types it at the call
    """Put x - sum of shares (x - h) into ``out`` (n, channels), with the recursion for h in ``inner``."""
    for n in range(x.shape[0]):
        for c in range(x.shape[1]):
            out[n, c] = x[n, c]
        for i in range(shares.size):
            for c in range(x.shape[1]):
                inner[i, c] = keep[n, i] * inner[i, c] + take[n, i] * (x[n, c] - before[c])
                out[n, c] -= shares[i] * (x[n, c] - inner[i, c])
        for c in range(x.shape[1]):
            before[c] = x[n, c]
