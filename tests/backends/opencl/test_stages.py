"""Tiles of stages and terms on OpenCL: cut or whole, one step a launch or many, what is read where it lies."""

from typing import Any

import numpy as np
import pytest

from cnnsim import PERIODIC, ZERO_FLUX, LayeredTemplate, Template, Term, fixed
from cnnsim.backends.opencl import stage_tiles
from cnnsim.backends.opencl.channel_text import ChannelText
from cnnsim.backends.opencl.device.context import DeviceContext
from cnnsim.backends.term_table import table_of
from cnnsim.task import make_task
from tests.kits.networks import assert_like_the_reference
from tests.kits.opencl import FAMILIES, Family, OpenCLBackend

NINE = np.arange(1, 10).reshape(3, 3) * 0.03 * np.array([[1, -1, 1], [-1, 1, 1], [1, 1, -1]])
TERM = Template(NINE, NINE, terms=[Term(NINE, "y_kl - u_ij", times="x_kl")])
FAR = Template(np.random.default_rng(1).normal(size=(5, 5)) / 9, z=0.1)
LAYERS = LayeredTemplate([Template(NINE, terms=[Term([[w]], layer=o)]) for w, o in ((-0.5, 1), (0.5, 0))])
CASES: dict[str, tuple[Any, dict[str, Any]]] = {
    "terms by euler": (TERM, {"scheme": "euler", "boundary": PERIODIC}),
    "terms by rk4, full range": (TERM, {"scheme": "rk4", "cell": "full-range", "boundary": ZERO_FLUX}),
    "linear by heun": (FAR, {"scheme": "heun", "boundary": PERIODIC}),
    "linear by rk4": (FAR, {"scheme": "rk4", "boundary": fixed(0.5, -0.3)}),
    "layers by heun": (LAYERS, {"scheme": "heun", "boundary": PERIODIC}),
    "discrete time": (Template(NINE, NINE), {"cell": "discrete-time", "boundary": PERIODIC}),
}


def task_of(case: str, shape: tuple[int, int]) -> Any:
    """A masked task on a batch of three grids."""
    template, choices = CASES[case]
    of_layers = (2,) if template is LAYERS else ()
    rng = np.random.default_rng(7)
    x, u, mask = rng.uniform(-1, 1, (3, 3, *of_layers, *shape))
    timed: dict[str, Any] = (
        {"duration": 7.0} if choices.get("cell") == "discrete-time" else {"duration": 1.1, "step": 0.1}
    )
    return make_task(template, state=x, input=u, mask=mask - 0.5, **timed, **choices)


@pytest.mark.parametrize("family", FAMILIES)
@pytest.mark.parametrize("case", CASES)
def test_many_steps_a_launch_have_the_bits_of_one_a_launch(
    case: str, family: Family, monkeypatch: pytest.MonkeyPatch
) -> None:
    backend, task = OpenCLBackend("float32", family=family), task_of(case, (9, 21))
    real, launches = DeviceContext.enqueue, list[str]()

    def counted(self: DeviceContext, kernel: Any, *shape: Any) -> None:
        launches.append(kernel.function_name)
        real(self, kernel, *shape)

    monkeypatch.setattr(DeviceContext, "enqueue", counted)
    many = backend.read(task.start(backend).x)
    assert sum(name in ("do_steps", "do_discretes") for name in launches) == 1
    assert "do_step" not in launches
    monkeypatch.setattr(stage_tiles, "_stays_whole", lambda *_: False)
    launches.clear()
    one = backend.read(task.start(backend).x)
    assert sum(name in ("do_step", "do_discrete") for name in launches) == task.plan.steps + (case == "discrete time")
    np.testing.assert_array_equal(many, one)


@pytest.mark.parametrize("family", FAMILIES)
@pytest.mark.parametrize("case", CASES)
def test_tiles_have_the_bits_of_a_grid_that_is_not_cut(
    case: str, family: Family, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Tiles on a torus begin at any column, so that a vector's cells lie in two words of the mask."""
    backend, task = OpenCLBackend("float32", family=family), task_of(case, (40, 150))
    monkeypatch.setattr(stage_tiles, "_stays_whole", lambda *_: False)
    found = []
    for size in ((40, 150), (17, 64)):
        monkeypatch.setattr(stage_tiles, "_cut", lambda *_, size=size, **__: size)
        found.append(backend.read(task.start(backend).x))
    np.testing.assert_array_equal(found[0], found[1])


def test_state_and_output_of_the_cell_itself_are_read_where_they_are() -> None:
    """What is copied into a tile are the channels of neighbours, of inputs and of other layers."""
    step = Template([[2.0]], terms=[Term(NINE, "u_kl - x_ij"), Term([[0.5]], "y_kl", times="u_kl - y_ij")])
    other = LayeredTemplate([Template([[2.0]], terms=[Term([[0.3]], "y_kl", layer=1)]), Template([[0.5]])])
    rng = np.random.default_rng(3)
    for template, wanted, shape in (
        (step, [("u", 0)], (6, 9)),
        (other, [("y", 1)], (2, 6, 9)),
    ):
        x, u = rng.uniform(-1, 1, (2, *shape))
        for scheme in ("euler", "rk4"):
            task = make_task(template, state=x, input=u, scheme=scheme, step=0.1, duration=1.0)
            text = ChannelText(table_of(task.plan, np.dtype("float64"), static=False), outputs=True)
            assert [(seen.quantity, seen.layer) for seen in text.seen()] == wanted
            for family in FAMILIES:
                assert_like_the_reference(OpenCLBackend("float64", family=family), task, bound=4.0)
