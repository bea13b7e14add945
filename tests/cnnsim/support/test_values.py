"""What arrays mean as CNN values, by one rule at every door."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import cnnsim
from cnnsim import (
    InputError,
    LayeredTemplate,
    Template,
    Term,
    UniversalMachine,
    from_gray,
    load_program,
    run,
    run_program,
    run_transient,
    to_planes,
    trajectory,
    write_picture,
)
from cnnsim.library import load
from cnnsim.network.table import parse_table

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


def test_the_edge_of_a_boolean_square() -> None:
    assert int((run("edge", SQUARE).y > 0).sum()) == 16


@pytest.mark.parametrize("door", DOORS)
def test_grey_levels_are_refused_with_what_converts_them(door: Callable[[Any], Any]) -> None:
    levels = np.where(SQUARE, 0, 255).astype(np.uint8)
    for wrong in (levels, levels.astype(int)):
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


@pytest.mark.parametrize("wrong", [SQUARE, [[0.0, 0.5]], [[0.0, 0.5, 1.0]], [[True]], [["a"]], [[1], [1, 2]]])
def test_what_is_no_grey_level(wrong: Any) -> None:
    """Booleans would be two shades of black, fractions of 1 nearly so."""
    with pytest.raises(InputError, match=r"True is black|a top, as of|numbers wanted|no rectangular"):
        from_gray(wrong)
    assert from_gray([[0.0, 0.5, 1.0]], top=1).tolist() == [[1.0, 0.0, -1.0]]


@pytest.mark.parametrize(
    ("wrong", "said"),
    [
        ([["a"]], "holds <U1 values; real numbers or booleans"),
        ([[1], [1, 2]], r"no rectangular array of numbers: entry 0 has shape \(1,\), entry 1 \(2,\)"),
        ([np.zeros((8, 8)), np.zeros((3, 3))], r"no rect.* entry 0 has shape \(8, 8\), entry 1 \(3, 3\); one shape"),
        (None, "is None; an array of numbers wanted"),
        (cnnsim.Frames([SQUARE], 1.0), r"is Frames\(1 plane .*; an array of numbers wanted: the list of its planes"),
        ([[None]], "holds object values"), ([[1j]], "holds complex128 values"),
        ("scan.png", r"is 'scan.png'; .*cnnsim.read_picture\(path\)"),
        (np.ma.array(np.eye(3), mask=np.eye(3) > 0), "is a masked array; a plain one wanted"),
    ],
)  # fmt: skip
def test_what_is_no_plane(wrong: Any, said: str) -> None:
    with pytest.raises(InputError, match=said):
        run_transient(Template([[2.0]]), state=wrong)
    with pytest.raises(InputError, match=said):
        run("edge", wrong)


@pytest.mark.parametrize("dtype", [np.uint8, np.int64])
def test_zeros_and_ones_are_logic_values_alone(dtype: Any) -> None:
    """As grey levels, 0 and 1 of 255 would both be black: that cure is not named."""
    ones = SQUARE.astype(dtype)
    with pytest.raises(InputError, match="wanted: values > 0"):
        run("edge", ones)
    assert np.array_equal(by_machine(ones), by_machine(SQUARE))
    assert np.array_equal(run("edge", SQUARE, mask=ones).y, run("edge", SQUARE, mask=SQUARE).y)


def test_truth_values_as_floats_are_told_where_white_is_wanted() -> None:
    """A spot on mid-grey is a picture for grey templates; a black-and-white one answers it with more than its rim."""
    with pytest.warns(UserWarning, match="'edge' takes -1 as white, 0 as mid-grey: values > 0") as told:
        wrong = run("edge", SQUARE.astype(float))
    assert told[0].filename == __file__
    assert (wrong.y > 0).sum() != (run("edge", SQUARE).y > 0).sum()
    run("average", SQUARE.astype(float))
    with pytest.warns(UserWarning, match="state holds 0 and 1 alone; template 'recall' takes -1 as white"):
        run("recall", SQUARE, state=SQUARE.astype(float))


def test_floats_that_are_all_0_are_told_of_as_a_picture_in_black_and_white_alone(recwarn: Any) -> None:
    with pytest.warns(UserWarning, match="picture holds 0 alone; template 'edge' takes -1 as white"):
        run("edge", np.zeros((9, 9)))
    recwarn.clear()
    run("average", np.zeros((9, 9)))  # a grey picture
    run("recall", SQUARE, state=np.zeros((9, 9)))  # a state between both
    run_transient(EDGE.template, state=np.zeros((9, 9)), input=SQUARE)
    assert [str(told.message) for told in recwarn] == []


def test_a_mask_of_bytes() -> None:
    """Black is held in a picture, 255 in an array of truth values: both cures are named."""
    with pytest.raises(InputError, match=r"mask holds .* from 0 to 255.*from_gray\(values\); values > 0 where"):
        run("edge", SQUARE, mask=SQUARE.astype(np.uint8) * 255)


def test_a_single_run_of_a_program_checks_its_values() -> None:
    picture = np.where(SQUARE, 1.0, -1.0)
    with pytest.raises(InputError, match="picture holds nan; finite numbers wanted"):
        run_program("opening", picture=np.where(SQUARE, np.nan, picture))
    with pytest.raises(InputError, match="reads as colours"):
        run_program("opening", picture=np.ones((9, 9, 3)))
    with pytest.warns(UserWarning, match="picture reaches 255"):
        run_program("opening", picture=255.0 * SQUARE)
    with pytest.raises(InputError, match=r"frame has shape \(2, 9, 9\), independent grids"):
        run_program("motion-detection", frame=[picture, -picture])


@pytest.mark.parametrize("values", [np.full((3, 3), np.nan), np.eye(3, dtype=np.uint8) * 255, np.ones((2, 2, 3, 3))])
def test_what_is_no_picture_is_not_written(values: Any, tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"holds nan; finite|cnnsim.from_gray|\(rows, cols\) wanted"):
        write_picture(values, tmp_path / "p.png")
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize(
    "call",
    [
        lambda: run(None, SQUARE), lambda: run(Template(2.0), SQUARE), lambda: run_program(None),  # type: ignore[arg-type]  # mistakes
        lambda: UniversalMachine().run("opening", picture=SQUARE),  # type: ignore[arg-type]  # the same
        lambda: Template(2.0, terms=3), lambda: LayeredTemplate([Template(2.0)], ["a"]),  # type: ignore[arg-type, list-item]  # the same
        lambda: LayeredTemplate(3), lambda: LayeredTemplate([Template(2.0)], 1.0),  # type: ignore[arg-type]  # the same
        lambda: list(trajectory(Template(2.0), state=SQUARE, until=1, frames=0)),
        lambda: list(trajectory(Template(2.0), state=SQUARE, until=1, frames=1.5)),  # type: ignore[arg-type]  # the same
        lambda: list(trajectory(Template(2.0), state=SQUARE, until=np.nan, frames=1)),
        lambda: run_transient(Template(2.0), state=SQUARE, without="slep"),
    ],
)  # fmt: skip
def test_a_mistake_is_told_in_one_line(call: Callable[[], Any]) -> None:
    with pytest.raises(InputError, match=r"^[^\n]*wanted[^\n]*$"):
        call()


def test_whole_numbers_of_numpy() -> None:
    one: Any = np.int64(1)
    assert Term([[1.0]], layer=one).layer == 1
    assert run("edge", SQUARE, threads=one).settled


def test_a_misspelled_end_of_a_step_is_told() -> None:
    step = {"at": [0], "values": [0, 1]}
    assert parse_table({"step": step | {"closed": "left"}}).closed == "left"
    with pytest.raises(InputError, match="closed 'rigth'; step or linear, right or left wanted"):
        parse_table({"step": step | {"closed": "rigth"}})
