"""Values of another kind at the doors of Python end in one line that says what is wanted; none is passed over."""

from collections.abc import Callable
from fractions import Fraction
from typing import Any

import numpy as np
import pytest

import cnnsim
from cnnsim import InputError, Template, backends, load_program, run, run_program, run_transient

PLANE = np.random.default_rng(2).uniform(-1, 1, (5, 6))
ANY: Any = 3
CASES: dict[str, tuple[Callable[[], Any], str]] = {
    "fraction": (lambda: run("diffusion", PLANE, duration=ANY * Fraction(1, 2)), r"duration Fraction\(3, 2\)"),
    "step": (lambda: run("diffusion", PLANE, step=ANY * Fraction(1, 30)), r"step Fraction\(1, 10\)"),
    "without": (lambda: run("hole-filler", PLANE, without=ANY), "without 3; names of savings"),
    "backend": (lambda: run("edge", PLANE, backend=ANY), "backend 3; one of reference, cpu, opencl, or a backend"),
    "machine": (lambda: cnnsim.UniversalMachine(ANY), "backend 3; one of reference"),
    "trajectory": (
        lambda: list(cnnsim.trajectory(Template(2.0), state=PLANE, until=1.0, frames=1, backend=ANY)),
        "backend 3",
    ),
    "program": (lambda: load_program(ANY), "program 3; the name of one of the library, or a file"),
    "template": (lambda: cnnsim.library.load(ANY), "template 3; the name of one of the library"),
    "dtype": (
        lambda: run("edge", PLANE, backend=backends.get("cpu", "float32"), dtype="float64"),
        "dtype 'float64' with an existing backend of float32",
    ),
    "threads": (
        lambda: run_program("opening", picture=PLANE, backend=backends.get("cpu"), threads=1),
        "threads 1 with an existing backend of float32",
    ),
    "explain": (lambda: cnnsim.explain(ANY), "template 3; a template, a program or the name of one"),
    "picture": (lambda: cnnsim.read_picture(ANY), "path 3; the name of a file"),
    "pictures": (lambda: cnnsim.read_pictures(ANY), "path 3; the name of a file"),
    "levels": (lambda: cnnsim.read_picture("a.png", levels=ANY), "levels 3; two numbers wanted"),
    "type": (lambda: cnnsim.read_pictures("a.png", dtype=int), "dtype <class 'int'>; a type of floats"),
    "scale": (lambda: cnnsim.write_picture(PLANE, "a.png", scale=0), "scale 0; a whole number of pixels"),
    "bias": (
        lambda: run_transient(Template(2.0), state=PLANE, bias=np.full((5, 6), 200, np.uint8)),
        r"bias holds whole numbers from 200 to 200.*from_gray",
    ),
    "all black": (
        lambda: cnnsim.run("edge", np.ones((5, 6), np.uint8)),
        "from_gray.*; values > 0 where they are truth",
    ),
}


@pytest.mark.parametrize("name", CASES)
def test_one_line(name: str) -> None:
    call, message = CASES[name]
    with pytest.raises(InputError, match=message):
        call()


@pytest.mark.parametrize("door", [lambda p: run("edge", p), lambda p: cnnsim.explain("edge", p)])
def test_a_warning_points_to_the_line_that_called(door: Callable[[Any], Any]) -> None:
    with pytest.warns(UserWarning, match="0 and 1 alone") as told:
        door(np.eye(4))
    assert told[0].filename == __file__


def test_numbers_of_numpy_become_plain_ones() -> None:
    minus: Any = np.float32(-1)
    assert repr(cnnsim.fixed(minus)) == "Boundary(kind='fixed', y=-1.0, u=-1.0)"


def test_what_is_meant_goes_on() -> None:
    own = backends.get("cpu", "float64")
    assert run("edge", PLANE, backend=own, dtype="float64").x.dtype == np.float64
    whole = run_transient(Template(0.0), state=PLANE, bias=np.full((5, 6), 2, np.int64), duration=20.0)
    assert np.allclose(whole.x, 2.0, atol=1e-5)
    bits = run_transient(Template(0.0), state=PLANE, bias=np.ones((5, 6), np.uint8), duration=20)
    assert np.allclose(bits.x, 1.0, atol=1e-5)
