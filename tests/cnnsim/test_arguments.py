"""What callers may write for numbers, boundaries and dtypes, and what is said of the rest."""

from typing import Any

import numpy as np
import pytest

from cnnsim import Boundary, InputError, Result, fixed, run

MINUS_ONE: Any = np.int64(-1)
PICTURE = np.where(np.random.default_rng(0).random((8, 8)) > 0.5, 1.0, -1.0)


def ended(**changes: Any) -> Result:
    return run("hole-filler", PICTURE, **changes)


@pytest.mark.parametrize(
    ("loose", "strict"),
    [
        ({"boundary": "fixed:-1"}, {"boundary": fixed(-1)}),
        ({"boundary": Boundary("fixed", MINUS_ONE, MINUS_ONE)}, {"boundary": fixed(-1)}),
        ({"duration": np.int64(3)}, {"duration": 3.0}),
        ({"duration": np.float32(3)}, {"duration": 3.0}),
        ({"limit": np.int32(50)}, {"limit": 50.0}),
        ({"step": np.float64(0.05)}, {"step": 0.05}),
    ],
)
def test_numbers_of_numpy_and_written_boundaries(loose: dict[str, Any], strict: dict[str, Any]) -> None:
    assert np.array_equal(ended(**loose).x, ended(**strict).x)


@pytest.mark.parametrize(
    ("wrong", "message"),
    [
        ({"limit": "x"}, "limit 'x'; a number"),
        ({"step": "x"}, "step 'x'; a positive number"),
        ({"duration": True}, "duration True; 'settled' or a number"),
        ({"dtype": "foo"}, "dtype 'foo'; float32 or float64 wanted"),
        ({"boundary": "foo"}, "boundary 'foo'; wanted 'zero-flux'.*w } }$"),
        ({"boundary": "zeroflux"}, "boundary 'zeroflux'; wanted .*; did you mean 'zero-flux'"),
        ({"duration": 1e18}, r"1e\+18 time constants in steps of 0.1; at most 1e\+12 steps"),
        ({"duration": 1e308, "step": 1e-3}, r"at most 1e\+12 steps"),
        ({"step": 1e-300}, r"360 time constants in steps of 1e-300; at most 1e\+12 steps"),
    ],
)
@pytest.mark.parametrize("backend", ["reference", "cpu"])
def test_what_is_said_of_the_rest(wrong: dict[str, Any], message: str, backend: str) -> None:
    with pytest.raises(InputError, match=message):
        ended(**wrong, backend=backend)
