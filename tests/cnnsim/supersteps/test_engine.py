"""Engines: names, sides of blocks, steps of a superstep, missing libraries."""

import math
import sys
from pathlib import Path

import numpy as np
import pytest

import cnnsim
from cnnsim.network import ZERO_FLUX, Template
from cnnsim.planning.plan import make_plan
from cnnsim.supersteps.engine import Engine, side_of_blocks, steps_of_superstep
from cnnsim.support import InputError
from cnnsim.sweep.table import SweepTable
from cnnsim.workers import open_workers


@pytest.mark.parametrize("workers", [1, 2, 3, 7])
@pytest.mark.parametrize("rows", [64, 1000, 4096, 10000, 16384, 65536])
def test_blocks_fit_in_memory_are_of_one_size_and_occupy_all_workers(
    rows: int, workers: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("CNNSIM_MEMORY", "16G")
    side = side_of_blocks(Engine(), (rows, rows), workers)
    down = math.ceil(rows / side)
    assert 64 * workers * side**2 <= 8e9
    assert (down * side - rows) / side < 0.5
    if rows > 1000:
        assert down**2 / workers / math.ceil(down**2 / workers) > 0.7
    assert side_of_blocks(Engine(side=48), (rows, rows), workers) == 48


def test_less_memory_gives_smaller_blocks(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("CNNSIM_MEMORY", "512M")
    assert side_of_blocks(Engine(), (32768, 32768), 2) <= 1472
    with pytest.raises(InputError, match="2 workers with blocks of 2000 x 2000 cells needs"):
        x = np.zeros((2000, 2000), np.float32)
        cnnsim.run_transient(Template(2.0), state=x, duration=1.0, step=0.1, engine=Engine(workers=2, side=2000))


def test_a_superstep_until_settled_has_whole_check_intervals() -> None:
    template = Template([[0, 0.1, 0], [0.1, 2, 0.1], [0, 0.1, 0]])
    settling = make_plan(template, (512, 512), ZERO_FLUX)
    assert settling.check_every == 10
    assert [steps_of_superstep(Engine(), settling, side) for side in (32, 64, 512, 4096)] == [2, 10, 30, 250]
    timed = make_plan(template, (512, 512), ZERO_FLUX, duration=50.0)
    assert steps_of_superstep(Engine(), timed, 4096) == 250  # two supersteps of 500 steps
    assert steps_of_superstep(Engine(depth=7), timed, 4096) == 7


@pytest.mark.parametrize(
    ("name", "message"),
    [
        ("dask", "engine 'dask' without an address; dask=tcp://HOST:PORT of a running scheduler wanted"),
        ("dask=", "engine 'dask=' without an address"),
        ("spark", "engine 'spark'; processes or dask=ADDRESS wanted"),
        ("dask=nowhere", "no scheduler answers at nowhere"),
    ],
)
def test_wrong_names_are_refused_in_one_line(name: str, message: str) -> None:
    pytest.importorskip("distributed")
    with pytest.raises(InputError, match=message) as found, open_workers(name):
        pass
    assert "\n" not in str(found.value)


def test_without_the_extra_one_line_names_it(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    wanted = pytest.raises(InputError, match=r"missing: pip install .*scale")
    for library in ("zarr", "distributed", "pyarrow"):
        monkeypatch.setitem(sys.modules, library, None)
    with wanted:
        cnnsim.run_transient(cnnsim.Template(1.0), state=np.zeros((4, 4)), duration=1.0, engine="processes")
    with wanted, open_workers("dask=tcp://127.0.0.1:1"):
        pass
    with wanted:
        SweepTable(tmp_path, "")
