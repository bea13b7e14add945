"""One rule at every door: booleans are black and white, grey levels and colours are refused with their cure."""

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

import cnnsim
from cnnsim import Frames, InputError, backends, fixed, library
from cnnsim.library.entry import Example
from cnnsim.prototyping.design.expression import parse_rule
from cnnsim.prototyping.design.fit import fit
from cnnsim.prototyping.design.rule_files import rule_of_pairs
from cnnsim.prototyping.trace.trace import record
from cnnsim.task import make_task

BLACK = np.zeros((9, 9), dtype=bool)
BLACK[2:7, 2:7] = True
VALUES = np.where(BLACK, 1.0, -1.0)
EDGE = library.load("edge").network
ZERO = np.zeros((9, 9))
REFERENCE = backends.get("reference")


def transient(picture: Any) -> Any:
    return cnnsim.run_transient(EDGE, state=ZERO, input=picture, boundary=fixed(-1), backend="reference").y


def sequence(picture: Any) -> Any:
    frames = Frames([picture], 1.0)
    given: dict[str, Any] = {"state": ZERO, "input": frames, "duration": 4.0, "boundary": fixed(-1)}
    return cnnsim.run_transient(EDGE, **given, backend="reference").y


DOORS: dict[str, Callable[[Any], Any]] = {
    "run": lambda p: cnnsim.run("edge", p, backend="reference").y,
    "the second picture": lambda p: cnnsim.run("recall", VALUES, state=p, backend="reference").y,
    "run_transient": transient,
    "a sequence": sequence,
    "an analog input of a program": lambda p: cnnsim.run_program("gray-opening", picture=p, backend="reference"),
    "trace": lambda p: record(make_task(EDGE, state=ZERO, input=p), REFERENCE, 1.0, 2).y,
    "fit": lambda p: fit([(p, VALUES)], fixed(-1), generations=1).template.A,
    "rule of pairs": lambda p: rule_of_pairs([(VALUES, p)], fixed(-1)).table,
    "example": lambda p: Example(p, None, VALUES).input,
    "plot": lambda p: cnnsim.plot.plane(p, matplotlib_axes()).images[0].get_array(),
}
LOGIC: dict[str, Callable[[Any], Any]] = {
    "a logic input of a program": lambda p: cnnsim.run_program("opening", picture=p, backend="reference"),
    "mask": lambda p: cnnsim.run("hole-filler", VALUES, mask=p, backend="reference").y,
    "rule": lambda p: parse_rule("c and ring8 < 8").answer(p, fixed(-1)),
}


def matplotlib_axes() -> Any:
    from matplotlib.figure import Figure

    return Figure().add_subplot()


def same(one: Any, other: Any) -> bool:
    if isinstance(one, dict):
        return all(same(one[key], other[key]) for key in one)
    return np.array_equal(np.asarray(one), np.asarray(other))


@pytest.mark.parametrize("door", [*DOORS, *LOGIC])
def test_booleans_are_black_and_white(door: str) -> None:
    enter = {**DOORS, **LOGIC}[door]
    assert same(enter(BLACK), enter(VALUES))
    assert same(enter(BLACK.tolist()), enter(VALUES))


@pytest.mark.parametrize("door", [*DOORS, *LOGIC])
@pytest.mark.parametrize("dtype", [np.uint8, np.int64])
def test_grey_levels_are_refused(door: str, dtype: Any) -> None:
    with pytest.raises(InputError, match="from_gray"):
        {**DOORS, **LOGIC}[door](np.where(BLACK, 0, 255).astype(dtype))


@pytest.mark.parametrize("door", ["run", "run_transient", "a sequence", "an analog input of a program", "example"])
def test_colours_are_refused(door: str) -> None:
    with pytest.raises(InputError, match="to_planes"):
        DOORS[door](np.zeros((9, 9, 3), np.uint8))


@pytest.mark.parametrize("channels", [3, 4])
def test_colours_between_0_and_1_are_no_narrow_grids(channels: int) -> None:
    with pytest.raises(InputError, match=r"\(9, 9, .\), which reads as colours.*to_planes"):
        cnnsim.run("edge", np.ones((9, 9, channels)), backend="reference")
    assert cnnsim.run("edge", np.ones((9, 4, channels)), backend="reference").y.shape == (9, 4, channels)


@pytest.mark.parametrize("door", DOORS)
def test_whole_numbers_0_and_1_are_no_black_and_white(door: str) -> None:
    with pytest.raises(InputError, match=r"0 and 1, and 0 is mid-grey.*values > 0"):
        DOORS[door](BLACK.astype(int))


@pytest.mark.parametrize("door", DOORS)
@pytest.mark.parametrize("dtype", [np.int8, np.int64])
def test_the_whole_number_0_alone_is_no_picture(door: str, dtype: Any) -> None:
    """It would be black as a grey level, white as a truth value, and mid-grey as a CNN value: it is ambiguous."""
    for zeros in (np.zeros((9, 9), dtype), np.zeros((9, 9), dtype).tolist()):
        with pytest.raises(InputError, match=r"the whole number 0 alone.*from_gray\(values\), values > 0, or floats"):
            DOORS[door](zeros)


def test_zeros_that_have_a_meaning_are_taken() -> None:
    """A bias and a mask of 0 do nothing, a state of floats 0 is one, and so is a single number for all cells."""
    given: dict[str, Any] = {"state": ZERO, "boundary": fixed(-1), "backend": "reference"}
    plain = cnnsim.run_transient(EDGE, input=VALUES, **given).y
    nothing = np.zeros((9, 9), int)
    assert same(cnnsim.run_transient(EDGE, input=VALUES, bias=nothing, mask=nothing, **given).y, plain)
    assert same(cnnsim.run_transient(EDGE, input=0, **given).y, cnnsim.run_transient(EDGE, input=ZERO, **given).y)


@pytest.mark.parametrize("door", LOGIC)
def test_where_above_0_is_black_0_and_1_will_do(door: str) -> None:
    assert same(LOGIC[door](BLACK.astype(int)), LOGIC[door](VALUES))
    assert same(LOGIC[door](np.zeros((9, 9), int)), LOGIC[door](-np.ones((9, 9))))


def test_the_warning_names_the_caller_s_line() -> None:
    with pytest.warns(UserWarning, match=r"picture reaches 2\.5") as said:
        cnnsim.run("edge", 2.5 * VALUES, backend="reference")
    assert said[0].filename == __file__


@pytest.mark.parametrize("picture", [1.0, True, np.ones(9)])
def test_a_picture_has_rows_and_columns(picture: Any) -> None:
    for name in ("edge", "autowave", "moving-parts"):
        with pytest.raises(InputError, match=r"shape .*; \(rows, cols\) with at least one cell wanted"):
            cnnsim.run(name, picture)
