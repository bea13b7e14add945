"""Programs on an engine with one worker: random planes, comparison of results, a program with every kind of step."""

from typing import Any

import numpy as np

import cnnsim
from cnnsim.supersteps.engine import Engine
from cnnsim.support import Array

RANDOM = np.random.default_rng(4)
SHAPE = (40, 44)


def one(**choices: Any) -> Engine:
    return Engine(workers=1, **{"side": 24, **choices})


def drawn(shape: tuple[int, ...]) -> Array:
    found = RANDOM.random(shape) < 0.5
    found[..., 2:9, 3 : shape[-1] - 2] = True
    found[..., 4:7, 5:9] = False
    return found


def planes_of(program: cnnsim.Program, shape: tuple[int, ...]) -> dict[str, Any]:
    grey = RANDOM.integers(-64, 65, (len(program.inputs), *shape)) / 64
    return {
        name: drawn(shape) if program.memory[name] == "llm" else grey[number]
        for number, name in enumerate(program.inputs)
    }


def assert_same(found: dict[str, Any], dense: dict[str, Any]) -> None:
    assert found.keys() == dense.keys()
    for name, value in dense.items():
        assert np.asarray(found[name]).dtype == np.asarray(value).dtype, name
        assert np.asarray(found[name]).tobytes() == np.asarray(value).tobytes(), name


EVERYTHING = """
name = "everything"
lam = ["a", "b", "c"]
llm = ["p", "q", "r", "old"]
wire = ["n", "m", "k"]
inputs = ["a", "p"]
outputs = ["c", "r", "b", "q", "n", "m", "k"]
keep = { old = -1 }
[parameters]
times = 3
[templates.spread]
A = [[0, 0.4, 0], [0.4, 1.2, 0.4], [0, 0.4, 0]]
B = [[0, 0, 0], [0.1, 0.5, 0], [0, 0, 0]]
z = 0.1
boundary = "periodic"
duration = 1.3
[templates.grey]
A = [[0, 0.2, 0], [0.2, 0.1, 0.2], [0, 0.2, 0]]
B = 0.3
boundary = { fixed = 0.25 }
[[step]]
template = "spread"
input = "p"
state = "a"
bias = "a"
mask = "p"
to = "b"
[[step]]
template = "grey"
input = "b"
state = 0.5
to = "c"
[[step]]
copy = "c"
to = "q"
[[step]]
fill = 0.3
to = "a"
[[step]]
cellwise = "add"
of = ["a", "c"]
to = ["c"]
[[step]]
template = "dilation-cross"
input = "q"
boundary = "periodic"
to = "r"
[[step]]
logic = "xor"
of = ["r", "old"]
to = "r"
[[step]]
wire = "count"
of = "r"
to = "n"
[[step]]
wire = "any"
of = "r"
to = "m"
[[step]]
wire = "all"
of = "r"
to = "k"
[[step]]
repeat = "times"
[[step.do]]
number = "add"
of = ["n", 1]
to = "n"
[[step.do]]
template = "erosion-cross"
input = "r"
to = "r"
[[step]]
copy = "r"
to = "old"
"""
WAYS = """
[[step]]
when = "m"
[[step.do]]
until_unchanged = "r"
[[step.do.do]]
template = "erosion-cross"
input = "r"
to = "r"
[[step.otherwise]]
fill = 1
to = "r"
"""
