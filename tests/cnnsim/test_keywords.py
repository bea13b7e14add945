"""A misspelt keyword names the nearest one, at every door; and the types say which there are."""

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

import cnnsim
from cnnsim import InputError

PICTURE = np.ones((5, 6))
EDGE = cnnsim.library.load("edge").template


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda: cnnsim.run("edge", PICTURE, bondary="periodic"), "run: no keyword 'bondary'; did you mean 'boundary'"),  # type: ignore[call-arg]
        (lambda: cnnsim.run("edge", PICTURE, backed="cpu"), "did you mean 'backend'"),  # type: ignore[call-arg]
        (lambda: cnnsim.run("edge", PICTURE, recrod=[1.0]), "did you mean 'record'"),  # type: ignore[call-arg]
        (lambda: cnnsim.run_transient(EDGE, state=PICTURE, schema="rk4"), "did you mean 'scheme'"),  # type: ignore[call-arg]
        (lambda: cnnsim.explain("edge", (4, 4), durration=1.0), "did you mean 'duration'"),  # type: ignore[call-overload]
        (lambda: cnnsim.UniversalMachine(backnd="cpu"), "UniversalMachine: no .* mean 'backend'"),  # type: ignore[call-arg]
        (lambda: cnnsim.UniversalMachine(thread=1), "did you mean 'threads'"),  # type: ignore[call-arg]
        (lambda: cnnsim.run_program("opening", picture=PICTURE, backnd="cpu"), "did you mean 'backend'"),
        (lambda: list(cnnsim.trajectory(EDGE, state=PICTURE, until=1.0, frame=3)), "did you mean 'frames'"),  # type: ignore[call-arg]
    ],
)  # fmt: skip
def test_the_nearest_word_is_named(call: Callable[[], Any], message: str) -> None:
    with pytest.raises(InputError, match=message) as error:
        call()
    assert isinstance(error.value, TypeError) or "program" in str(error.value)


def test_an_input_of_a_program() -> None:
    machine = cnnsim.UniversalMachine()
    with pytest.raises(InputError, match="picture wanted; did you mean 'picture'"):
        machine.run(cnnsim.load_program("opening"), pictur=PICTURE)


@pytest.mark.parametrize("keyword", ["radius", "raduis"])
def test_a_parameter_is_no_input(keyword: str) -> None:
    with pytest.raises(InputError, match=r"radius is a parameter: load_program\('gray-opening', parameters="):
        cnnsim.run_program("gray-opening", **{"picture": PICTURE, keyword: np.ones(1)})  # type: ignore[arg-type]  # no keyword of it
