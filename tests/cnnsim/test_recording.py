"""What may be asked to be recorded, and what is said of the rest."""

from typing import Any

import numpy as np
import pytest

from cnnsim import InputError, NotSettledError, run

PICTURE = np.where(np.random.default_rng(0).random((8, 9)) > 0.5, 1.0, -1.0)


@pytest.mark.parametrize(
    ("record", "message"),
    [
        ([(8, 0)], r"cell \(8, 0\); rows 0 to 7, columns 0 to 8"),
        ([(0, -1)], r"cell \(0, -1\)"),
        ([-1.0], "times from -1 to -1; finite ones from 0 on"),
        ([np.nan], "finite ones"),
        ([], "times such as"),
        ("x", "times such as"),
        (3.0, "times such as"),
        ([[1, 2, 3]], "cells such as"),
        ([(1, 2), (3,)], "cells such as"),
        ([True, False], "times such as"),
    ],
)
def test_neither_times_nor_cells(record: Any, message: str) -> None:
    with pytest.raises(InputError, match=message):
        run("hole-filler", PICTURE, record=record)


def test_a_time_after_the_end_of_a_fixed_duration() -> None:
    with pytest.raises(InputError, match="time 3 after the end of the run; 0 to 2 wanted"):
        run("diffusion", PICTURE, duration=2.0, record=[1, 3])


def test_times_come_in_order_each_once_on_steps() -> None:
    found = run("hole-filler", PICTURE, backend="reference", record=[0.5, 0, 0.52, 1]).trajectory
    assert found is not None
    assert found.t == pytest.approx([0, 0.5, 1])
    assert found.of_cell(2, 3).tolist() == found.x[:, 2, 3].tolist()


def test_a_run_that_does_not_settle_is_recorded_too() -> None:
    with pytest.raises(NotSettledError) as error:
        run("hole-filler", PICTURE, limit=1.0, backend="reference", record=[(0, 0)])
    assert error.value.result.trajectory is not None
    assert len(error.value.result.trajectory) == 11


def test_the_adaptive_scheme_meets_every_time() -> None:
    found = run("diffusion", PICTURE, backend="reference", scheme="adaptive", duration=1.0, record=[0.33, 1.0])
    assert found.trajectory is not None
    assert np.array_equal(found.trajectory.x[-1], found.x)
