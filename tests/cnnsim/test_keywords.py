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
        (lambda: cnnsim.Template([[2.0]], b=[[1.0]]), "Template: no keyword 'b'; did you mean 'B'"),  # type: ignore[call-arg]
        (lambda: cnnsim.Frames([PICTURE], perid=1.0), "Frames: no keyword 'perid'; did you mean 'period'"),  # type: ignore[call-arg]
        (lambda: cnnsim.Term([[1.0]], dela=1.0), "did you mean 'delay'"),  # type: ignore[call-arg]
        (lambda: cnnsim.Boundary(knd="fixed"), "did you mean 'kind'"),  # type: ignore[call-arg]
        (lambda: cnnsim.read_picture("a.png", binry=True), "read_picture: no .* mean 'binary'"),  # type: ignore[call-arg]
        (lambda: cnnsim.read_pictures("a.png", level=(0, 1)), "read_pictures: no .* mean 'levels'"),  # type: ignore[call-arg]
        (lambda: cnnsim.write_picture(PICTURE, "a.png", scales=2), "write_picture: no .* mean 'scale'"),  # type: ignore[call-arg]
        (lambda: cnnsim.run_transient(EDGE), "run_transient: no state among its keywords; wanted"),  # type: ignore[call-arg]
        (lambda: list(cnnsim.trajectory(EDGE, frames=3)), "trajectory: no state, until among its"),  # type: ignore[call-arg]
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


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda: cnnsim.run_transient("edge", state=PICTURE), r"template 'edge'; a Template .*load\('edge'\).template"),  # type: ignore[arg-type]
        (lambda: cnnsim.run_transient([[1.0]], state=PICTURE, engine="processes"), r"template \[\[1.0\]\]; a Template"),  # type: ignore[arg-type]
        (lambda: list(cnnsim.trajectory(3, state=PICTURE, until=1.0, frames=2)), "template 3; a Template or"),  # type: ignore[arg-type]
        (lambda: cnnsim.UniversalMachine().kept("opening"), "program 'opening'; a Program"),  # type: ignore[arg-type]
        (lambda: cnnsim.UniversalMachine().prepare("opening", (3, 3)), "program 'opening'; a Program"),  # type: ignore[arg-type]
        (lambda: cnnsim.UniversalMachine().prepare(cnnsim.load_program("opening"), "ab"), r"shape 'ab'; .rows"),  # type: ignore[arg-type]
        (lambda: cnnsim.UniversalMachine().prepare(cnnsim.load_program("opening"), (3, 0)), r"shape \(3, 0\); \(rows"),
        (lambda: cnnsim.write_picture(PICTURE, None), "path None; the name of a file wanted"),  # type: ignore[arg-type]
    ],
)  # fmt: skip
def test_what_is_no_such_thing(call: Callable[[], Any], message: str) -> None:
    with pytest.raises(InputError, match=message):
        call()
