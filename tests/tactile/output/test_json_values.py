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


def test_values_in_json_are_written_as_python_writes_nine_digits() -> None:
    random = np.random.default_rng(0)
    values = random.normal(size=(40, 8, 3)) * 10.0 ** random.integers(-20, 20, (40, 8, 3))
    special = np.array(
        [
            0.0,
            -0.0,
            1,
            10,
            1e9,
            999999999.6,
            1e-4,
            9.9999999e-5,
            -1e-5,
            1e100,
            1e22,
            0.1,
            123456789,
            0.5,
            1e-7,
            99999999,
            1e8,
            12345678.9,
            -2.5,
            7e-300,
            9,
            1e-100,
            3,
            2e15,
        ]
    )
    values[0] = special.reshape(8, 3)
    made: Any = SimpleNamespace(values=values, valid=np.ones((40, 8), bool))
    text = frame_json(made, {}).partition('"values": ')[2][:-1]
    wanted = ["0" if abs(value) < 1e-290 and value else f"{value:.9g}" for value in values.ravel().tolist()]
    assert text.translate({ord("["): None, ord("]"): None}).rstrip("}").split(", ") == wanted
    assert np.array(json.loads(text)).shape == values.shape
