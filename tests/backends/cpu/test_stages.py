"""Stages of Runge-Kutta steps that stream through tiles: bit for bit the reference's steps, in float32 as well."""

from typing import Any

import numpy as np
import pytest

from cnnsim import Template
from cnnsim.backends import get
from cnnsim.backends.driver import run
from cnnsim.backends.reference.transient import ReferenceLinearSteps
from cnnsim.network import PERIODIC, ZERO_FLUX, Boundary, fixed
from cnnsim.planning.plan import make_plan
from cnnsim.planning.scheme import SCHEMES, Scheme

BACKENDS = {name: get("cpu", name) for name in ("float32", "float64")}
THREE_EIGHTHS = Scheme("3/8", ((), (1 / 3,), (-1 / 3, 1.0), (1.0, -1.0, 1.0)), (1 / 8, 3 / 8, 3 / 8, 1 / 8), order=4)
"""Its stages ask for the rates of all stages before them."""

NINE = Template([[0.1, 0.4, -0.1], [0.3, 1.2, -0.2], [0.05, 0.25, 0.15]], z=-0.1)
CROSS = Template([[0, 0.4, 0], [0.3, 1.5, -0.2], [0, 0.25, 0]], z=0.1)
WIDE = Template(np.outer([1, -2, 3, 2, 1], [1, 0, 2, -1, 0.5]) / 8)
WIDEST = Template(np.eye(11) / 8 + np.diag(np.full(11, 0.02))[::-1])
SHAPES = ((1, 1), (9, 1), (2, 3), (5, 40), (37, 66), (20, 1300), (530, 12), (3, 17, 70))


def both(
    template: Template, shape: tuple[int, ...], boundary: Boundary, dtype: str, *, masked: bool, **choices: Any
) -> tuple[Any, Any]:
    """Return the outcome of the loops, and of the reference's steps in the same numbers."""
    rng, where = np.random.default_rng(len(shape) + shape[-1]), BACKENDS[dtype]
    x, free = rng.uniform(-1, 1, shape).astype(dtype), rng.random(shape) < (0.7 if masked else 1.0)
    plan = make_plan(template, shape, boundary, step=0.1, **choices)
    w = np.full_like(x, template.z)
    found = where.transient(plan, where.load(x, "lam"), None, None, where.load(~free, "llm") if masked else None)
    return found, run(plan, ReferenceLinearSteps(plan, x, w, free))


@pytest.mark.parametrize("boundary", [fixed(0.25), ZERO_FLUX, PERIODIC], ids=str)
@pytest.mark.parametrize("template", [NINE, CROSS, WIDE, WIDEST], ids=["nine", "cross", "radius 2", "radius 5"])
@pytest.mark.parametrize("dtype", BACKENDS)
def test_all_bits_are_those_of_the_reference(
    dtype: str, template: Template, boundary: Boundary, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setitem(SCHEMES, "3/8", THREE_EIGHTHS)
    cases = [(s, m, c) for s in ("heun", "rk4", "3/8") for m in (False, True) for c in ("chua-yang", "full-range")]
    cases += [("euler", True, "chua-yang"), ("euler", False, "full-range"), ("euler", True, "full-range")]
    for number, (scheme, masked, cell) in enumerate(cases):
        shape = SHAPES[(number + len(boundary.kind) + template.A.size) % len(SHAPES)]
        found, wanted = both(template, shape, boundary, dtype, masked=masked, scheme=scheme, cell=cell, duration=0.7)
        np.testing.assert_array_equal(found.x, wanted.x, err_msg=f"{scheme} {shape} {masked} {cell}")


@pytest.mark.parametrize("masked", [False, True])
@pytest.mark.parametrize("cell", ["chua-yang", "full-range"])
@pytest.mark.parametrize("scheme", ["heun", "rk4"])
def test_they_settle_when_the_reference_settles(scheme: str, cell: Any, masked: bool) -> None:
    for template, limit in ((Template([[0, 0, 0], [0, 2, 0], [0, 0, 0]], z=0.3), 9.0), (NINE, 1.0)):
        for shape in ((3, 17, 70), (37, 66)):
            found, wanted = both(
                template, shape, ZERO_FLUX, "float64", masked=masked, scheme=scheme, cell=cell, limit=limit
            )
            assert (found.t, found.settled, found.rate) == (wanted.t, wanted.settled, wanted.rate)
            np.testing.assert_array_equal(found.x, wanted.x)


@pytest.mark.parametrize("scheme", ["heun", "rk4"])
def test_many_steps_a_pass_are_one_step_a_pass(scheme: str) -> None:
    where, x = BACKENDS["float32"], np.random.default_rng(1).uniform(-1, 1, (90, 140)).astype(np.float32)
    plans = [
        make_plan(NINE, x.shape, PERIODIC, duration=1.1, scheme=scheme, step=0.1, without=without)
        for without in ([], ["blocking"])
    ]
    assert plans[0].depth > 1 == plans[1].depth
    one, other = (where.transient(plan, x, None).x for plan in plans)
    np.testing.assert_array_equal(one, other)


def test_the_threads_change_no_bit() -> None:
    x = np.random.default_rng(1).uniform(-1, 1, (200, 300)).astype(np.float32)
    plan = make_plan(NINE, x.shape, ZERO_FLUX, duration=0.5, scheme="rk4", step=0.1)
    one, other = (get("cpu", "float32", None, threads).transient(plan, x, None).x for threads in (1, 2))
    np.testing.assert_array_equal(one, other)
