"""Tables in files of arrays: NPY, NPZ, MATLAB (v5 and v7.3), HDF5 and Parquet."""

from pathlib import Path
from typing import Any

import numpy as np

from cnnsim.support import InputError
from cnnsim.support.array_files import mapped_array, open_npz
from cnnsim.support.extras import need
from cnnsim.support.limits import check_unpacked, one_line
from cnnsim.support.memory import check_memory
from tactile.layout.table import EXTRA, Table, flat, usable

MATLAB_HDF5 = b"\x89HDF"
"""First bytes of a MATLAB file of version 7.3 after its header of 512 bytes, and of an HDF5 file."""
HEADER = 512


def read_npy(path: Path, _: Any) -> Table:
    """Return the array of an NPY file as column ``data``, or the fields of a structured array."""
    with one_line(path, "an array of NumPy"):
        mapped = mapped_array(path)
        check_memory(f"{path}: reading {mapped.nbytes} bytes", mapped.nbytes, "give a smaller array")
        whole = np.array(mapped)
    return _table(path, {name: whole[name] for name in whole.dtype.names} if whole.dtype.names else {"data": whole})


def read_npz(path: Path, _: Any) -> Table:
    """Return the arrays of an NPZ file."""
    found, left = {}, []
    with open_npz(path, "table") as file:
        for name in file.files:
            try:
                found[name] = file[name]
            except ValueError:  # Python objects, which are not loaded
                left.append(name)
    return _table(path, found, [f"Python objects are not read: {', '.join(left)}"] if left else [])


def read_mat(path: Path, layout: Any) -> Table:
    """Return the variables of a MATLAB file; the fields of a structure are named ``a.b``."""
    with one_line(path, "a MATLAB file"):
        with path.open("rb") as file:
            file.seek(HEADER)
            hdf5 = file.read(len(MATLAB_HDF5)) == MATLAB_HDF5
        if hdf5:
            return read_hdf5(path, layout)
        from scipy.io import loadmat  # slow to import

        found = loadmat(path, simplify_cells=True)
    return _table(path, flat({name: one for name, one in found.items() if not name.startswith("__")}))


def read_hdf5(path: Path, _: Any) -> Table:
    """Return the data sets of an HDF5 file by path, ``a/b``; those of a MATLAB file with their axes in its order."""
    h5py = need("h5py", "an HDF5 file", EXTRA)
    found: dict[str, Any] = {}
    matlab = path.suffix.lower() == ".mat"

    def visit(name: str, one: Any) -> None:
        if not isinstance(one, h5py.Dataset) or name.startswith("#") or one.shape is None:
            return
        size = one.size * one.dtype.itemsize
        check_unpacked(path, size)
        check_memory(f"{path}: reading {size} bytes of {name}", size, "give smaller data sets")
        read = one.asstr()[...] if h5py.check_string_dtype(one.dtype) else one[...]
        fields = {f"{name}/{part}": read[part] for part in one.dtype.names} if one.dtype.names else {name: read}
        for key, value in fields.items():
            array = np.asarray(value).astype(str) if np.asarray(value).dtype.kind == "O" else np.asarray(value)
            found[key.replace("/", ".") if matlab else key] = array.T if matlab else array

    with one_line(path, "an HDF5 file"), h5py.File(path, "r") as file:
        file.visititems(visit)
    return _table(path, {name: np.squeeze(one) if matlab else one for name, one in found.items()})


def read_parquet(path: Path, _: Any) -> Table:
    """Return the columns of a Parquet file; equally long lists become arrays, times become ns."""
    parquet = need("pyarrow.parquet", "a Parquet file", EXTRA)
    found, left = {}, []
    with one_line(path, "a Parquet file"), parquet.ParquetFile(path) as file:
        groups = (file.metadata.row_group(group) for group in range(file.metadata.num_row_groups))
        check_unpacked(path, sum(group.total_byte_size for group in groups))
        read = file.read()
        while any(str(one.type).startswith("struct") for one in read.schema):
            read = read.flatten()
        for name in read.column_names:
            array = arrow_array(read.column(name))
            if array is None:
                left.append(name)
            else:
                found[name] = array
    return _table(path, found, [f"no numbers, or lists of unequal lengths: {', '.join(left)}"] if left else [])


def arrow_array(column: Any) -> Any:
    """Return a column of pyarrow as an array (rows, ...), None if it holds neither numbers, texts nor equal lists."""
    types, compute = need("pyarrow.types", "a table", EXTRA), need("pyarrow.compute", "a table", EXTRA)
    column = column.combine_chunks() if hasattr(column, "combine_chunks") else column
    kind = column.type
    if types.is_list(kind) or types.is_large_list(kind) or types.is_fixed_size_list(kind):
        rows = len(column)
        inside = arrow_array(column.flatten())
        even = inside is not None and rows and not column.null_count and len(inside) % rows == 0
        if not even or len(set(compute.list_value_length(column).to_pylist())) > 1:
            return None
        return inside.reshape(rows, -1, *inside.shape[1:])
    if types.is_timestamp(kind):
        found = column.to_numpy(zero_copy_only=False).astype("datetime64[ns]")
        return found.astype(np.int64) if not np.isnat(found).any() else np.where(np.isnat(found), np.nan, found)
    if types.is_boolean(kind) or types.is_integer(kind) or types.is_floating(kind) or types.is_decimal(kind):
        found = column.to_numpy(zero_copy_only=False)
        return found.astype(np.float64) if found.dtype.kind not in "biuf" else found
    if types.is_string(kind) or types.is_large_string(kind) or types.is_dictionary(kind):
        return np.array(["" if one is None else str(one) for one in column.to_pylist()])
    return None


def _table(path: Path, columns: dict[str, Any], notes: list[str] | None = None) -> Table:
    kept, left = usable(columns)
    if not kept:
        raise InputError(f"{path}: no array of numbers in it; it holds {', '.join(columns) or 'nothing'}")
    return Table(path, kept, (*(notes or ()), *left))
