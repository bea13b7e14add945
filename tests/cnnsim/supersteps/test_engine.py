import math

import pytest

from cnnsim.network import ZERO_FLUX, Template
from cnnsim.planning.plan import make_plan
from cnnsim.supersteps.block_task import BlockReport
from cnnsim.supersteps.depth import Depth
from cnnsim.supersteps.engine import WORKER_BYTES, Engine, side_of_blocks, worker_bytes


@pytest.mark.parametrize("workers", [1, 2, 3, 7])
@pytest.mark.parametrize("rows", [64, 1000, 4096, 10000, 16384, 65536])
def test_blocks_fit_leave_no_slivers_and_keep_all_workers_busy(
    rows: int, workers: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("CNNSIM_MEMORY", "16G")
    for sleeps in (False, True):
        side = side_of_blocks(Engine(), (rows, rows), workers, sleeps=sleeps)
        down = math.ceil(rows / side)
        assert side <= 4096
        assert 64 * workers * side**2 <= 8e9
        assert sleeps or (down * side - rows) / side < 0.5  # the last ones are blocks, too
        if rows > 1000:
            assert down**2 / workers / math.ceil(down**2 / workers) > 0.7  # hardly anybody waits
        if sleeps and rows > 64:
            assert down**2 >= 4 * workers
        if sleeps and rows > 1000:  # a front from the edges keeps few awake
            assert 4 * (down - 1) / down**2 <= (0.13 if rows >= 16384 else 0.25 if rows >= 8192 else 0.44)


def test_the_depth_is_what_costs_least_by_the_measured_rates() -> None:
    def learnt(disk: float, stepping: float) -> int:
        depth = Depth(1024, 1, None, None)
        depth.learn([BlockReport(0, (), disk, stepping)], 16)
        return depth.steps(10**6)

    assert learnt(0.001, 1.0) < learnt(0.1, 1.0) < learnt(1.0, 1.0)

    def cost(d: int) -> float:  # of a step: cells of a halo that becomes narrower, and the disk once in d steps
        return 1.0 / 16 * ((1024 + d) / (1024 + 16)) ** 2 + 0.1 / d

    assert abs(learnt(0.1, 1.0) - min((int(2 ** (p / 2)) for p in range(17)), key=cost)) <= 1
    assert math.isclose(cost(16), 1.0 / 16 + 0.1 / 16)


@pytest.mark.parametrize("scheme", ["euler", "rk4"])
@pytest.mark.parametrize("backend", ["cpu", "opencl"])
def test_a_worker_takes_what_its_backend_makes_of_a_block(backend: str, scheme: str) -> None:
    plan = make_plan(Template(2.0), (512, 512), ZERO_FLUX, duration=1.0, scheme=scheme)
    needed = worker_bytes(plan, 100, 0, 1, 4, 1, has_mask=False, backend=backend)
    planes = (needed - WORKER_BYTES) / (4 * 100**2)
    assert planes == 8  # two given, the end, w, a plane to step to; as read, as given
