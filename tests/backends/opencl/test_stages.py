"""Networks in padded planes: many steps of whole grids a launch, or one stage of lines, give the same bits."""

from typing import Any

import numpy as np
import pytest

from cnnsim import PERIODIC, ZERO_FLUX, LayeredTemplate, Template, Term, fixed
from cnnsim.backends.opencl import padded
from cnnsim.backends.opencl.device.context import DeviceContext
from cnnsim.task import make_task
from tests.kits.opencl import FAMILIES, Family, OpenCLBackend

NINE = np.arange(1, 10).reshape(3, 3) * 0.03 * np.array([[1, -1, 1], [-1, 1, 1], [1, 1, -1]])
FAR = Template(np.random.default_rng(1).normal(size=(5, 5)) / 9, NINE)
TERM = Template(NINE, NINE, 0.1, terms=[Term(NINE, "y_kl - u_ij", times="x_kl")])
LAYERS = LayeredTemplate([Template(NINE, terms=[Term([[w]], layer=o)]) for w, o in ((-0.5, 1), (0.5, 0))])
DELAY = Template(NINE, NINE, terms=[Term(NINE, "y_kl", delay=0.3), Term(0.1, "x_kl - u_ij", delay=0.2)])
CASES: dict[str, tuple[Any, dict[str, Any]]] = {
    "terms by euler": (TERM, {"scheme": "euler", "boundary": PERIODIC}),
    "terms by rk4, full range": (TERM, {"scheme": "rk4", "cell": "full-range", "boundary": ZERO_FLUX}),
    "linear by heun": (FAR, {"scheme": "heun", "boundary": PERIODIC}),
    "linear by rk4": (FAR, {"scheme": "rk4", "boundary": fixed(0.5, -0.3)}),
    "layers by heun": (LAYERS, {"scheme": "heun", "boundary": PERIODIC}),
    "delays by heun": (DELAY, {"scheme": "heun", "boundary": ZERO_FLUX}),
    "discrete time": (Template(NINE, NINE), {"cell": "discrete-time", "boundary": PERIODIC}),
}


@pytest.mark.parametrize("family", FAMILIES)
@pytest.mark.parametrize("case", CASES)
def test_many_steps_a_launch_have_the_bits_of_one_stage_a_launch(
    case: str, family: Family, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A masked batch of three grids."""
    template, choices = CASES[case]
    layers, rng = ((2,) if template is LAYERS else ()), np.random.default_rng(7)
    x, u, mask = rng.uniform(-1, 1, (3, 3, *layers, 9, 21))
    timed: dict[str, Any] = (
        {"duration": 7.0} if choices.get("cell") == "discrete-time" else {"duration": 1.1, "step": 0.1}
    )
    task = make_task(template, state=x, input=u, mask=mask - 0.5, **timed, **choices)
    backend, launches, enqueue = OpenCLBackend("float32", family=family), list[str](), DeviceContext.enqueue

    def counted(self: DeviceContext, kernel: Any, *arguments: Any) -> None:
        launches.append(kernel.function_name)
        enqueue(self, kernel, *arguments)

    monkeypatch.setattr(DeviceContext, "enqueue", counted)
    ends, counts = [], []
    for cells in (padded.WHOLE_CELLS, 0):
        monkeypatch.setattr(padded, "WHOLE_CELLS", cells)
        monkeypatch.setattr(padded, "CACHE_BYTES", cells)
        ends.append(backend.read(task.start(backend).x))
        counts.append(sum(name in ("step_network", "discrete") for name in launches))
        launches.clear()
    stages = 1 if task.plan.scheme is None else len(task.plan.scheme.b)
    assert counts == [1, task.plan.steps * stages]
    np.testing.assert_array_equal(ends[0], ends[1])
