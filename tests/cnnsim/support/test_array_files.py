"""Arrays of NumPy files that are larger than their file or than the memory are refused in one line."""

import io
import zipfile
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from numpy.lib import format as npy

from cnnsim import InputError, read_pictures
from cnnsim.support.array_files import mapped_array, read_array, read_npz_arrays
from tactile import open_source

READERS: dict[str, tuple[str, Callable[[Path], Any]]] = {
    "a picture": ("x.npy", read_pictures),
    "a picture of an archive": ("x.npz", read_pictures),
    "heights": ("x.npy", read_array),
    "a plane on an engine": ("x.npy", mapped_array),
    "a model": ("x.npz", lambda path: read_npz_arrays(path, "model", ("s0_force",))),
    "a recording": ("x.npz", open_source),
}


def write(path: Path, shape: tuple[int, ...], numbers: int) -> Path:
    """Write an .npy file with a header of a shape, or an .npz file of one such array as recordings of pillars have."""
    out = io.BytesIO()
    npy.write_array_header_1_0(out, {"descr": "<f8", "fortran_order": False, "shape": shape})
    data = out.getvalue() + bytes(8 * numbers)
    if path.suffix == ".npz":
        with zipfile.ZipFile(path, "w") as archive:
            archive.writestr("s0_force.npy", data)
    else:
        path.write_bytes(data)
    return path


@pytest.mark.parametrize("reader", READERS)
def test_an_array_larger_than_its_file_is_refused(reader: str, tmp_path: Path) -> None:
    name, read = READERS[reader]
    with pytest.raises(InputError, match=rf"{name}: ") as error:
        read(write(tmp_path / name, (10**6, 10**6), 100))
    assert "\n" not in str(error.value)


@pytest.mark.parametrize("reader", [name for name in READERS if name != "a plane on an engine"])
def test_an_array_larger_than_the_memory_is_refused(
    reader: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("CNNSIM_MEMORY", "1M")
    name, read = READERS[reader]
    with pytest.raises(InputError, match=r"needs 1.28 MB of memory, 1 MB are free; give"):
        read(write(tmp_path / name, (400, 400), 400 * 400))
