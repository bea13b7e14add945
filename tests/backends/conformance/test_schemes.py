"""Runge-Kutta schemes of any number of stages, of the library and of users' own."""

from typing import Any

import numpy as np
import pytest

from cnnsim import PERIODIC, InputError, Template, Term
from cnnsim.backends.base import Backend
from cnnsim.planning.scheme import SCHEMES, Scheme
from cnnsim.task import make_task
from tests.kits.networks import assert_like_the_reference
from tests.oracles.exact_transient import exact

KUTTA_3 = Scheme("kutta-3", ((), (1 / 2,), (-1.0, 2.0)), (1 / 6, 2 / 3, 1 / 6), order=3)
THREE_EIGHTHS = Scheme("3/8", ((), (1 / 3,), (-1 / 3, 1.0), (1.0, -1.0, 1.0)), (1 / 8, 3 / 8, 3 / 8, 1 / 8), order=4)
BUTCHER_5 = Scheme(
    "butcher-5",
    ((), (1 / 4,), (1 / 8, 1 / 8), (0.0, -1 / 2, 1.0), (3 / 16, 0.0, 0.0, 9 / 16),
     (-3 / 7, 2 / 7, 12 / 7, -12 / 7, 8 / 7)),
    (7 / 90, 0.0, 32 / 90, 12 / 90, 32 / 90, 7 / 90), order=5,
)  # fmt: skip
"""Butcher, "Numerical Methods for Ordinary Differential Equations", sect. 336: order 5 in six stages."""

ALL = {**SCHEMES, **{scheme.name: scheme for scheme in (KUTTA_3, THREE_EIGHTHS, BUTCHER_5)}}
FEEDBACK = np.array([[0.1, 0.3, 0.1], [0.2, 1.4, -0.1], [0, 0.3, 0.1]])


@pytest.mark.parametrize("cell", ["chua-yang", "full-range"])
@pytest.mark.parametrize("scheme", ALL.values(), ids=list(ALL))
def test_every_scheme(backend: Backend, scheme: Scheme, cell: Any, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(SCHEMES, scheme.name, scheme)
    x = np.random.default_rng(2).uniform(-1, 1, (6, 9))
    for template in (Template(FEEDBACK, z=0.2), Template(0.5, z=0.2, terms=[Term(FEEDBACK, "x_kl")])):
        task = make_task(template, state=x, mask=x - 0.8, scheme=scheme.name, step=0.1, duration=1.0, cell=cell)
        assert_like_the_reference(backend, task, bound=3.0)


@pytest.mark.parametrize("scheme", ["heun", "rk4"])
def test_masked_cells_are_held_in_the_stages_too(backend: Backend, scheme: str) -> None:
    """Neighbours of a masked cell see its value in every stage, so that the order of the scheme is kept."""
    rng = np.random.default_rng(3)
    x, mask = rng.uniform(-1, 1, (5, 7)), rng.random((5, 7)) < 0.4
    truth = exact(FEEDBACK, np.full(x.shape, 2.5), x, PERIODIC, 1.0, mask=mask)
    for template in (Template(FEEDBACK, z=2.5), Template(0.0, z=2.5, terms=[Term(FEEDBACK, "y_kl")])):
        task = make_task(
            template, state=x, mask=mask, scheme=scheme, step=1 / 32, duration=1.0, boundary=PERIODIC
        )  # fmt: skip
        np.testing.assert_allclose(backend.read(task.start(backend).x), truth, atol=2e-3)


@pytest.mark.parametrize("terms", [(), (Term(FEEDBACK, "x_kl"),)], ids=["linear", "terms"])
def test_the_adaptive_scheme_is_the_reference_or_is_refused(backend: Backend, terms: tuple[Term, ...]) -> None:
    x = np.random.default_rng(2).uniform(-1, 1, (3, 4))
    task = make_task(Template(FEEDBACK, terms=terms), state=x, scheme="adaptive", duration=1.0)
    try:
        assert_like_the_reference(backend, task, bound=3.0)
    except InputError as error:
        assert "the adaptive scheme runs on the reference backend" in str(error)
