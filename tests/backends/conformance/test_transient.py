"""The verb for transients, on linear templates: random ones end as on the reference, on grids of all sizes."""

from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings

from cnnsim import Boundary, Template, fixed, run_transient
from cnnsim.backends.base import Backend
from cnnsim.task import make_task
from tests.kits.backends import COMPILING
from tests.kits.networks import REPEATING, assert_like_the_reference, linear_tasks, number_of_examples, settling_task

NINE = np.arange(1, 10).reshape(3, 3) * 0.03 * np.array([[1, -1, 1], [-1, 1, 1], [1, 1, -1]])
BOUNDARIES = [*REPEATING, fixed(0.5, -0.3), fixed(-1.0)]


def test_random_transients_of_given_durations(backend: Backend) -> None:
    @settings(max_examples=number_of_examples(backend))
    @given(five=linear_tasks())
    def all_end_as_on_the_reference(five: list[dict[str, Any]]) -> None:
        for choices in five:
            bias = 0.0 if choices["bias"] is None else np.abs(choices["bias"]).max()
            assert_like_the_reference(backend, make_task(**choices), choices["template"].state_bound(bias))

    all_end_as_on_the_reference()


@pytest.mark.parametrize("seed", range(6))
def test_random_transients_that_settle_or_not(backend: Backend, seed: int) -> None:
    if backend.name in COMPILING and seed > 2:
        pytest.skip("each builds kernels of its own")
    task = make_task(**settling_task(seed))
    assert_like_the_reference(backend, task, max(1.0, task.plan.template.state_bound(4.0)))


@pytest.mark.parametrize("boundary", BOUNDARIES, ids=str)
@pytest.mark.parametrize("shape", [(1, 1), (1, 5000), (5000, 3), (2, 3), (70, 1100)], ids=str)
@pytest.mark.parametrize("scheme", ["euler", "rk4"])
def test_hard_sizes(backend: Backend, scheme: str, shape: tuple[int, int], boundary: Boundary) -> None:
    template = Template(NINE, NINE.T, 0.1)
    if shape == (2, 3):  # smaller than the radius
        template = Template(np.random.default_rng(0).normal(size=(7, 7)) / 30, np.ones((11, 11)) / 121)
    rng = np.random.default_rng(1)
    task = make_task(
        template, state=rng.uniform(-2, 2, shape), input=rng.uniform(-1, 1, shape), boundary=boundary, duration=1.7,
        scheme=scheme,
    )  # fmt: skip
    assert_like_the_reference(backend, task, max(1.0, template.state_bound(4.0)))


@pytest.mark.parametrize(("cell", "scheme"), [("chua-yang", "euler"), ("full-range", "euler"), ("chua-yang", "rk4")])
def test_masked_cells_keep_their_state_bit_for_bit(backend: Backend, cell: Any, scheme: str) -> None:
    rng = np.random.default_rng(7)
    x, mask = rng.uniform(-1, 1, (9, 9)).astype(np.float32), rng.uniform(-1, 1, (9, 9))
    t = Template(rng.normal(size=(3, 3)), rng.normal(size=(3, 3)), 0.2)
    end = run_transient(
        t, state=x, input=x, mask=mask, duration=3.0, cell=cell, scheme=scheme, step=0.05, backend=backend
    ).x
    assert np.array_equal(end[mask > 0], x[mask > 0])
    assert not np.array_equal(end[mask <= 0], x[mask <= 0])


def test_a_batch_is_its_grids_one_by_one(backend: Backend) -> None:
    rng = np.random.default_rng(3)
    x, u, bias, mask = rng.uniform(-1, 1, (4, 3, 17, 23))
    for a in (NINE, np.diag([0, 2.0, 0])):
        t = Template(a, NINE.T, 0.1)
        whole = run_transient(t, state=x, input=u, bias=bias, mask=mask, duration=2.0, backend=backend).x
        for i, end in enumerate(whole):
            planes: dict[str, Any] = {"state": x[i], "input": u[i], "bias": bias[i], "mask": mask[i]}
            assert np.array_equal(end, run_transient(t, **planes, duration=2.0, backend=backend).x)


@pytest.mark.parametrize("method", ["closed form", "euler", "rk4"])
def test_planes_that_are_given_stay_as_they_are(backend: Backend, method: str) -> None:
    rng = np.random.default_rng(5)
    template = Template(2.0, NINE) if method == "closed form" else Template(NINE, NINE)
    x, u, bias = rng.uniform(-1, 1, (3, 12, 30))
    mask = rng.random((12, 30)) < 0.2
    task = make_task(
        template, state=x, input=u, bias=bias, mask=mask, duration=2.0,
        scheme=None if method == "closed form" else method, step=None if method == "closed form" else 0.1,
    )  # fmt: skip
    planes = [backend.load(x, "lam"), backend.load(u, "lam"), backend.load(bias, "lam"), backend.load(mask, "llm")]
    before = [backend.read(plane) for plane in planes]
    backend.transient(task.plan, planes[0], planes[1], planes[2], planes[3])
    for plane, was in zip(planes, before, strict=True):
        assert np.array_equal(backend.read(plane), was)
