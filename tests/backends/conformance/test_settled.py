"""Transients that settle: the pictures of the library's templates are the reference's, and so is the time."""

import numpy as np
import pytest

from cnnsim import Template, Term, library, run
from cnnsim.backends.base import Backend, check_area
from cnnsim.task import make_task
from tests.kits.backends import COMPILING, REFERENCE

NAMES = ["hole-filler", "recall", "shadow-left", "connectivity", "small-object-remover", "edge", "corner"]


@pytest.mark.parametrize("name", NAMES)
def test_settled_pictures_and_their_times(backend: Backend, name: str) -> None:
    shapes = [(16, 16), (40, 70)] if backend.name in COMPILING else [(1, 1), (1, 17), (9, 1), (16, 16), (40, 70)]
    for shape in shapes:
        rng = np.random.default_rng(shape[1])
        picture = np.where(rng.random(shape) < 0.5, 1.0, -1.0)
        given = library.load(name).initial_state == "given"
        marker = np.where(rng.random(shape) < 0.1, picture, -1.0) if given else None
        law = run(name, picture, state=marker, backend=REFERENCE)
        ours = run(name, picture, state=marker, backend=backend)
        assert ours.settled
        assert ours.t == law.t
        assert np.array_equal(np.sign(ours.y), np.sign(law.y)), shape


@pytest.mark.parametrize("terms", [(), (Term(np.full((3, 3), 0.05), "x_kl"),)], ids=["linear", "terms"])
def test_a_check_of_an_area_leaves_the_other_cells_out(backend: Backend, terms: tuple[Term, ...]) -> None:
    x = np.random.default_rng(1).uniform(-1, 1, (30, 70))
    plan = make_task(Template(2.0, z=0.2, terms=terms), state=x, step=0.1).plan
    for area in (((3, 9), (60, 70)), ((0, 1), (0, 1))):
        law, found = (
            check_area(where, plan, (where.load(x, "lam"), None, None, None), area) for where in (REFERENCE, backend)
        )
        assert found.rate == pytest.approx(law.rate, rel=1e-5)
        assert found.saturated == law.saturated
