"""What arrays mean as CNN values, by one rule at every door."""

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

import cnnsim
from cnnsim import InputError, Template, UniversalMachine, from_gray, load_program, run, run_transient, to_planes
from cnnsim.library import load

SQUARE = np.zeros((9, 9), bool)
SQUARE[2:7, 2:7] = True

EDGE = load("edge")


def by_transient(picture: Any) -> Any:
    return run_transient(EDGE.template, state=picture, input=picture, boundary=EDGE.boundary).y


def by_state(picture: Any) -> Any:
    return run_transient(Template([[2.0]]), state=picture).y


def by_machine(picture: Any) -> Any:
    return UniversalMachine().run(load_program("opening"), picture=picture)["opened"]


DOORS: list[Callable[[Any], Any]] = [lambda p: run("edge", p).y, by_transient, by_state, by_machine]


@pytest.mark.parametrize("door", DOORS)
def test_booleans_are_black_and_white(door: Callable[[Any], Any]) -> None:
    assert np.array_equal(door(SQUARE), door(np.where(SQUARE, 1.0, -1.0)))


def test_the_edge_of_a_boolean_square() -> None:
    assert int((run("edge", SQUARE).y > 0).sum()) == 16


@pytest.mark.parametrize("door", DOORS)
def test_grey_levels_are_refused_with_what_converts_them(door: Callable[[Any], Any]) -> None:
    levels = np.where(SQUARE, 0, 255).astype(np.uint8)
    for wrong in (levels, levels.astype(int), SQUARE.astype(np.uint8)):
        with pytest.raises(InputError, match=r"from -1 \(white\) to 1 \(black\) wanted: cnnsim.from_gray"):
            door(wrong)
    with pytest.raises(InputError, match=r"\(9, 9, 3\).*cnnsim.to_planes"):
        door(np.stack([levels] * 3, axis=-1))
    assert np.array_equal(door(from_gray(levels)), door(SQUARE))


def test_whole_numbers_of_the_range_are_values() -> None:
    assert run_transient(Template([[2.0]]), state=[[1, -1]]).y.tolist() == [[1.0, -1.0]]


def test_a_picture_beyond_the_range_is_told() -> None:
    with pytest.warns(UserWarning, match="picture reaches 3; CNN values lie from -1"):
        run("edge", 3.0 * np.where(SQUARE, 1, -1))


def test_colours() -> None:
    pixel = np.array([[[255, 0, 51, 255], [0, 0, 0, 0]]])
    assert to_planes(pixel[..., :3])[:, 0, 0].tolist() == [-1.0, 1.0, pytest.approx(0.6)]
    assert to_planes(pixel)[:, 0, 1].tolist() == [-1.0, -1.0, -1.0]  # nothing there: the white behind it
    assert from_gray(1.0, top=1.0) == -1.0
    for wrong in ([[256]], [[-1]], [[np.nan]]):
        with pytest.raises(InputError, match="0 to 255 wanted"):
            cnnsim.from_gray(wrong)
    with pytest.raises(InputError, match=r"3 or 4\) wanted"):
        to_planes([[1, 2]])


@pytest.mark.parametrize("wrong", [[["a"]], [[1], [1, 2]], [[None]], [[1j]]])
def test_what_is_no_plane(wrong: Any) -> None:
    with pytest.raises(InputError, match="no rectangular array of numbers"):
        run_transient(Template([[2.0]]), state=wrong)
