"""What the head of an array says is held against its file, and against the memory, before a number of it is read."""

import io
import tracemalloc
import zipfile
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.lib import format as npy

from cnnsim import InputError, read_pictures
from cnnsim.support.array_files import mapped_array, read_array, read_npz_arrays
from tactile import open_source

HUGE = r"800 bytes of numbers, and its head says 1000000 x 1000000 of float64, which take 8000000000000 \(8 TB\); a "


def head(shape: tuple[int, ...], version: tuple[int, int] = (1, 0)) -> bytes:
    out = io.BytesIO()
    write = npy.write_array_header_1_0 if version == (1, 0) else npy.write_array_header_2_0
    write(out, {"descr": "<f8", "fortran_order": False, "shape": shape})
    return out.getvalue()


def write(path: Path, data: bytes) -> Path:
    """Write an .npy file, or an .npz file of one such array under the name that recordings of pillars have."""
    if path.suffix == ".npz":
        with zipfile.ZipFile(path, "w") as archive:
            archive.writestr("s0_force.npy", data)
    else:
        path.write_bytes(data)
    return path


READERS: dict[str, tuple[str, Callable[[Path], Any]]] = {
    "a picture": ("x.npy", read_pictures),
    "a picture of an archive": ("x.npz", read_pictures),
    "heights": ("x.npy", read_array),
    "a plane on an engine": ("x.npy", mapped_array),
    "a model": ("x.npz", lambda path: read_npz_arrays(path, "model", ("s0_force",))),
    "a recording": ("x.npz", open_source),
}


@pytest.mark.parametrize("version", [(1, 0), (2, 0)])
@pytest.mark.parametrize("reader", READERS)
def test_more_than_the_file_holds_is_refused_before_it_is_asked_for(
    reader: str, version: tuple[int, int], tmp_path: Path
) -> None:
    name, read = READERS[reader]
    path = write(tmp_path / name, head((10**6, 10**6), version) + bytes(800))
    tracemalloc.start()
    with pytest.raises(InputError, match=HUGE):
        read(path)
    assert tracemalloc.get_traced_memory()[1] < 10e6
    tracemalloc.stop()


@pytest.mark.parametrize("reader", [name for name in READERS if name != "a plane on an engine"])
def test_more_than_the_memory_holds_is_refused(reader: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("CNNSIM_MEMORY", "1M")
    name, read = READERS[reader]
    path = write(tmp_path / name, head((400, 400)) + bytes(400 * 400 * 8))
    with pytest.raises(InputError, match=r"needs 1.28 MB of memory, 1 MB are free; give"):
        read(path)


def test_a_file_that_is_whole_is_read(tmp_path: Path) -> None:
    for version in ((1, 0), (2, 0)):
        path = write(tmp_path / "x.npy", head((2, 3), version) + np.arange(6.0).tobytes())
        assert read_array(path).tolist() == [[0, 1, 2], [3, 4, 5]]
