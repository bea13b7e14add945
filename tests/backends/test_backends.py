"""Every backend against the reference: random templates, grids, boundaries, masks, bias maps, schemes, cells."""

from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from cnnsim import PERIODIC, ZERO_FLUX, InputError, Template, fixed, library, run, run_transient
from cnnsim.backends import NAMES
from cnnsim.planning.scheme import SCHEMES

BACKENDS = [name for name in NAMES if name != "reference"]


@st.composite
def tasks(draw: st.DrawFn) -> list[dict[str, Any]]:
    """Five random transients of one rule (an OpenCL device compiles each rule) with a time and planes of their own.

    Rounding errors cannot grow beyond about fifty times their size: an error in x grows at most like
    exp((sum|A| - 1) t), so the running time is kept below ln(50) / (sum|A| - 1).
    """
    rng = np.random.default_rng(draw(st.integers(0, 2**32)))
    r, s = draw(st.integers(1, 3)), draw(st.integers(1, 3))
    a = rng.normal(size=(2 * r + 1, 2 * r + 1)) * (
        rng.random((2 * r + 1, 2 * r + 1)) < draw(st.sampled_from([0.3, 1.0]))
    )
    b = rng.normal(size=(2 * s + 1, 2 * s + 1))
    a *= draw(st.floats(0.5, 4)) / max(np.abs(a).sum(), 1e-9)
    b /= np.abs(b).sum()
    longest = min(5.0, np.log(50) / max(np.abs(a).sum() - 1, 0.1))
    rule = {
        "template": Template(a, b, rng.normal()),
        "boundary": draw(st.sampled_from([ZERO_FLUX, PERIODIC, fixed(-1.0), fixed(0.3, -0.7)])),
        "scheme": draw(st.sampled_from([None, *SCHEMES])),
        "cell": draw(st.sampled_from(["chua-yang", "full-range"])),
    }

    def planes() -> dict[str, Any]:
        shape: tuple[int, ...] = (draw(st.integers(1, 20)), draw(st.integers(1, 20)))
        if draw(st.booleans()):
            shape = (draw(st.integers(1, 3)), *shape)
        return {
            "state": rng.uniform(-1, 1, shape),
            "input": rng.uniform(-1, 1, shape),
            "bias": rng.normal(size=shape) if draw(st.booleans()) else None,
            "mask": rng.uniform(-1, 1, shape) if draw(st.booleans()) else None,
            "duration": longest * draw(st.floats(0.1, 1)),
        }

    return [{**rule, **planes()} for _ in range(5)]


@pytest.mark.parametrize("backend", BACKENDS)
@pytest.mark.parametrize(("dtype", "tolerance"), [("float64", 1e-12), ("float32", 1e-5)])
@settings(max_examples=20)
@given(five=tasks())
def test_agrees_with_the_reference(backend: str, dtype: Any, tolerance: float, five: list[dict[str, Any]]) -> None:
    for task in five:
        template = task["template"]
        law = run_transient(**task, backend="reference")
        ours = run_transient(**task, backend=backend, dtype=dtype)
        bias = 0.0 if task["bias"] is None else np.abs(task["bias"]).max()
        assert np.abs(ours.x - law.x).max() <= tolerance * template.state_bound(bias)
        assert ours.t == law.t


@pytest.mark.parametrize("backend", BACKENDS)
@pytest.mark.parametrize("dtype", ["float64", "float32"])
@pytest.mark.parametrize(
    "name", ["hole-filler", "recall", "shadow-left", "connectivity", "small-object-remover", "edge", "corner"]
)
@pytest.mark.parametrize("shape", [(1, 1), (1, 17), (9, 1), (16, 16), (40, 33)])
def test_settled_pictures_are_identical(backend: str, dtype: Any, name: str, shape: tuple[int, int]) -> None:
    rng = np.random.default_rng(shape[1])
    picture = np.where(rng.random(shape) < 0.5, 1.0, -1.0)
    marker = np.where(rng.random(shape) < 0.1, picture, -1.0) if library.load(name).initial_state == "given" else None
    law = run(name, picture, state=marker, backend="reference")
    ours = run(name, picture, state=marker, backend=backend, dtype=dtype)
    assert ours.settled
    assert np.array_equal(np.sign(ours.y), np.sign(law.y))


@pytest.mark.parametrize("backend", ["reference", *BACKENDS])
@pytest.mark.parametrize("cell", ["chua-yang", "full-range"])
def test_held_cells_keep_their_state_bit_for_bit(backend: str, cell: Any) -> None:
    rng = np.random.default_rng(7)
    x, mask = rng.uniform(-1, 1, (9, 9)).astype(np.float32), rng.uniform(-1, 1, (9, 9))
    t = Template(rng.normal(size=(3, 3)), rng.normal(size=(3, 3)), 0.2)
    end = run_transient(t, state=x, input=x, mask=mask, duration=3.0, cell=cell, backend=backend).x
    assert np.array_equal(end[mask > 0], x[mask > 0])
    assert not np.array_equal(end[mask <= 0], x[mask <= 0])


@pytest.mark.parametrize("backend", ["reference", *BACKENDS])
def test_a_nan_in_a_plane_is_named(backend: str) -> None:
    picture = np.ones((4, 5))
    picture[2, 3] = np.nan
    with pytest.raises(InputError, match=r"holds nan in cell \(2, 3\)"):
        run("edge", picture, backend=backend)


@pytest.mark.parametrize("backend", ["reference", *BACKENDS])
def test_a_state_that_overflows_is_reported(backend: str) -> None:
    t = Template([[0, 0, 0], [0, 1, 0], [0, 0, 0]])
    x = np.zeros((3, 3))
    x[1, 2] = 1e308
    with pytest.raises(InputError, match=r"state is (inf|nan) in cell \(1, 2\)"):
        run_transient(
            t, state=x, bias=1.7 * x, duration=6.0, scheme="euler", step=1.9, backend=backend, dtype="float64"
        )


def test_the_reference_is_float64_only() -> None:
    with pytest.raises(InputError, match="float64, not in float32"):
        run("edge", np.ones((2, 2)), backend="reference", dtype="float32")


def test_an_unknown_backend_lists_the_known_ones() -> None:
    with pytest.raises(InputError, match="known are reference, cpu"):
        run("edge", np.ones((2, 2)), backend="gpu")
