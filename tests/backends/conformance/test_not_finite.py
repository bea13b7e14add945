"""Numbers that are none: refused in planes, reported where a state becomes one."""

from typing import Any

import numpy as np
import pytest

from cnnsim import InputError, Template, Term, run, run_transient
from cnnsim.backends.base import Backend, NotFiniteError
from cnnsim.task import make_task

NINE = np.arange(1, 10).reshape(3, 3) * 0.03 * np.array([[1, -1, 1], [-1, 1, 1], [1, 1, -1]])


def test_a_nan_in_a_plane_is_named(backend: Backend) -> None:
    picture = np.ones((4, 5))
    picture[2, 3] = np.nan
    with pytest.raises(InputError, match=r"holds nan in cell \(2, 3\)"):
        run("edge", picture, backend=backend)


@pytest.mark.parametrize("bad", [np.nan, np.inf])
@pytest.mark.parametrize("scheme", [None, "euler", "rk4"])
@pytest.mark.parametrize("duration", [0.5, "settled"])
def test_a_state_that_is_no_number_is_named(backend: Backend, duration: Any, scheme: Any, bad: float) -> None:
    template = Template(0.5 if scheme is None else NINE)
    x = np.zeros((9, 21))
    task = make_task(template, state=x, scheme=scheme, duration=duration, limit=2.0)
    x[4, 17] = bad
    with pytest.raises(NotFiniteError, match=r"the state is (nan|inf) in cell \("):
        task.start(backend, x)


def test_a_state_that_overflows_is_reported(backend: Backend) -> None:
    x = np.zeros((3, 3))
    x[1, 2] = np.finfo(backend.dtype).max / 1.8
    where = r"\(1, 2\)" if backend.dtype == "float64" else ""  # its neighbours may have caught it
    with pytest.raises(NotFiniteError, match=r"state is (inf|nan) in cell " + where):
        run_transient(
            Template([[0, 0, 0], [0, 1, 0], [0, 0, 0]], 1.5), state=x, input=x, bias=1.7 * x, duration=6.0,
            scheme="euler", step=1.9, backend=backend,
        )  # fmt: skip


def test_a_state_of_terms_that_overflows_is_reported(backend: Backend) -> None:
    growing = Template(0, terms=[Term([[3.0]], "x_kl")])
    with pytest.raises(NotFiniteError, match=r"the state is (inf|nan) in cell"):
        run_transient(growing, state=[[np.finfo(backend.dtype).max / 1e8]], duration=60.0, backend=backend)
