import sys
from pathlib import Path

import numpy as np
import pytest

import cnnsim
from cnnsim.support import InputError
from cnnsim.sweep.table import SweepTable
from cnnsim.workers import open_workers

PLANE = np.zeros((4, 4))


@pytest.mark.parametrize(
    ("library", "engine"), [("zarr", "processes"), ("joblib", "processes"), ("distributed", "dask")]
)
def test_without_the_extra_one_line_names_it(library: str, engine: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, library, None)
    with pytest.raises(InputError, match=r"missing: pip install .*scale") as told:
        if library == "zarr":
            cnnsim.run_transient(cnnsim.Template(1.0), state=PLANE, duration=1.0, engine=engine)
        else:
            with open_workers(engine, 2):
                pass
    assert "\n" not in str(told.value)


def test_a_sweep_without_pyarrow_names_the_extra(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "pyarrow", None)
    with pytest.raises(InputError, match=r"missing: pip install .*scale"):
        SweepTable(tmp_path, "")
