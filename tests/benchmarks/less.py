"""Savings: the closed form, sleeping tiles, packed logic."""

from collections.abc import Callable
from functools import partial

import numpy as np

from cnnsim import library
from cnnsim.backends.base import Backend, Plane
from cnnsim.network import ZERO_FLUX
from cnnsim.operations.bitwise import BitLiteral, BitRule
from cnnsim.operations.logic import function_number
from cnnsim.planning.plan import Plan, make_plan
from cnnsim.planning.savings import Saving
from tests.benchmarks.dense import backends
from tests.benchmarks.race import Row, race, versus

MANY = 20


def settle(backend: Backend, plan: Plan, x: Plane, u: Plane) -> None:
    """Run a transient and wait for its end."""
    backend.count(backend.convert(backend.transient(plan, x, u).x, "llm"))


def uncoupled(triad: float, rounds: int) -> list[Row]:
    """A template without neighbours in A, to equilibrium: by its closed form, and by steps.

    The limit is memory traffic: states and input are read, states written and read once more by the check.
    """
    entry, n = library.load("edge"), 2048
    picture = np.where(np.random.default_rng(0).random((n, n)) > 0.5, 1.0, -1.0)
    rows = []
    for who, backend in backends().items():
        planes = entry.planes(picture)
        x, u = backend.load(np.broadcast_to(planes["state"], picture.shape), "lam"), backend.load(picture, "lam")
        ways: dict[str, tuple[Saving, ...]] = {"closed form": (), "steps": ("closed form",)}
        plans = {way: make_plan(entry.template, (n, n), entry.boundary, without=w) for way, w in ways.items()}
        seconds = race({way: partial(settle, backend, plan, x, u) for way, plan in plans.items()}, rounds)
        rate = 1e-9 * 4 * n * n * backend.dtype.itemsize / seconds["closed form"]
        ratio = {**versus(seconds, "closed form"), "triad": rate / triad}
        rows.append(Row("uncoupled 2048^2 to rest", who, 1e3 * seconds["closed form"], "ms", ">= 20 x steps", ratio))
    return rows


def rings(n: int) -> np.ndarray:
    """Return a picture of circles that overlap, some with holes in them, as scipy's binary_fill_holes shows them."""
    rng = np.random.default_rng(0)
    i, j = np.mgrid[:n, :n]
    picture = np.zeros((n, n), bool)
    for _ in range(n // 10):
        y, x, r = (*rng.integers(0, n, 2), rng.integers(4, n // 16))
        part = np.s_[max(0, y - r - 3) : y + r + 4, max(0, x - r - 3) : x + r + 4]
        picture[part] |= np.abs(np.hypot(i[part] - y, j[part] - x) - r) < 1.5
    return np.where(picture, 1.0, -1.0)


def sleep(rounds: int) -> list[Row]:
    """The hole filler on 1024 x 1024 to convergence, with and without sleeping tiles."""
    entry, n = library.load("hole-filler"), 1024
    picture = rings(n)
    rows = []
    for who, backend in backends().items():
        x, u = backend.load(np.ones((n, n)), "lam"), backend.load(picture, "lam")
        plans = {w: make_plan(entry.template, (n, n), entry.boundary, without=w) for w in ((), ("sleep",))}
        ends = [backend.read(backend.transient(plan, x, u).x) for plan in plans.values()]
        seconds = race(
            {
                "sleep": partial(settle, backend, plans[()], x, u),
                "dense": partial(settle, backend, plans["sleep",], x, u),
            },
            rounds,
        )
        same = np.array_equal(np.clip(ends[0], -1, 1), np.clip(ends[1], -1, 1))
        ratio = versus(seconds, "sleep")
        note = "outputs identical" if same else "OUTPUTS DIFFER"
        rows.append(Row("hole filler 1024^2", who, 1e3 * seconds["sleep"], "ms", ">= 4 x dense", ratio, note))
    return rows


def many(backend: Backend, run: Callable[[], Plane]) -> None:
    """Do work many times, and wait for the last."""
    for _ in range(MANY):
        plane = run()
    backend.count(plane)


def logic(triad: float, rounds: int) -> list[Row]:
    """Logic, counting and a dilation on packed planes of 4096 x 4096 cells, in bytes of the packed planes."""
    n, rng = 4096, np.random.default_rng(0)
    square = BitRule(tuple(BitLiteral(k, l, False) for k in (-1, 0, 1) for l in (-1, 0, 1)), False)
    rows = []
    for who, backend in backends().items():
        p, q = (backend.load(rng.random((n, n)) > 0.5, "llm") for _ in range(2))
        function = function_number("p-and-not-q")
        work = {
            "logic": (3, partial(backend.logic, function, p, q)),
            "dilation 3x3": (2, partial(backend.neighbourhood, square, ZERO_FLUX, p)),
        }
        runs = {name: partial(many, backend, run) for name, (_, run) in work.items()}
        seconds = {name: s / MANY for name, s in race(runs, rounds).items()}
        work["count"] = 1, partial(backend.count, p)
        seconds |= race({"count": work["count"][1]}, 20 * rounds)
        for name, (planes, _) in work.items():
            rate = 1e-9 * planes * n * n / 8 / seconds[name]
            target = ">= 0.5 of triad" if name == "logic" else ""
            note = f"{1e6 * seconds[name]:.0f} us, {8 * rate / planes:.0f}e9 cells/s"
            rows.append(Row(f"{name} 4096^2, packed", who, rate, "GB/s", target, {"triad": rate / triad}, note))
    return rows
