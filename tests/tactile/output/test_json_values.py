"""Values of a frame in JSON."""

import json
from types import SimpleNamespace
from typing import Any

import numpy as np

from tactile.output.stream_frame import frame_json


def test_values_in_json_have_the_bits_of_float32_and_null_where_they_are_not_valid() -> None:
    values = np.random.default_rng(0).normal(0, 1e-5, (2, 3, 3)).astype(np.float32).astype(float)
    values[0, 0], values[1, 1, 2] = np.nan, -np.inf
    made: Any = SimpleNamespace(values=values, valid=np.array([[True, True, False], [True, True, True]]))
    read = json.loads(frame_json(made, {"t_s": 1.5}))
    assert read["t_s"] == 1.5
    got = np.array(read["values"], dtype=float)  # None is NaN
    wanted = np.where(made.valid[..., None] & np.isfinite(values), values, np.nan).astype(np.float32)
    assert np.array_equal(got.astype(np.float32), wanted, equal_nan=True)
    assert read["values"][0][0] == read["values"][0][2] == [None] * 3
