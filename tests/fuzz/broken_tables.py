"""Broken tables of labels and weights, films, and large pictures: NumPy arrays on the disk and Zarr arrays."""

import json
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import numpy as np

from tests.fuzz.broken_arrays import npy_head
from tests.fuzz.broken_texts import Broken
from tests.fuzz.changed_bytes import bytes_changed

TABLES = {
    "labels.csv": "recording,sensor,contact_s,release_s\na,0,1.0,2.0\nb,1,,\n",
    "slide_labels.csv": "recording,material,sensor,start_s,stop_s,speed_mm_s,block\na,oak,0,1.0,2.0,10,1\nb,oak,,,,,\n",
    "weights.csv": "from_s,to_s,grams,x_mm,y_mm\n0.0,1.0,100,0.0,0.0\n2.0,3.0,200,1.0,0.5\n",
}


def table_files(_folder: Path, count: int) -> Broken:
    """Tables: cells that are no numbers, lines too short and too long, quotes without an end, bytes of no text."""
    for name, good in TABLES.items():
        head, *rows = good.splitlines()
        names = head.split(",")
        for text in ("", "\n", head, head + "\n,", head + "\n" + "," * 100_000, head + '\n"' + "x" * 200_000,
                     "," * 100_000, head + ",extra\n" + rows[0], f"{head},{names[0]}\n{rows[0]}", "\0" * 1000,
                     head + "\n" + "1,2,3\n" * 100_000, head + "\n" + rows[0] + ",1,2,3", "\ufeff" + good):  # fmt: skip
            yield name, text.encode()
        for cell in ("nan", "inf", "-1e999", "9" * 5000, "", "x", "\x1b[2J", "=1+1", "1_0", "\u0661"):
            for place in range(len(names)):
                row = rows[0].split(",")
                yield name, f"{head}\n{','.join([*row[:place], cell, *row[place + 1 :]])}\n".encode()
        yield name, good.encode("utf-16")
        yield name, b"\xff\xfe" * 1000
        yield from bytes_changed(name, good.encode(), count)


ZARR = {
    "zarr_format": 3, "node_type": "array", "shape": [8, 8], "data_type": "uint8",
    "chunk_grid": {"name": "regular", "configuration": {"chunk_shape": [8, 8]}},
    "chunk_key_encoding": {"name": "default", "configuration": {"separator": "/"}}, "fill_value": 0,
    "codecs": [{"name": "bytes"}], "attributes": {},
}  # fmt: skip


def large_files(folder: Path, count: int) -> Broken:
    """Pictures that are read part by part, and films."""
    if find_spec("av"):
        from cnnsim.support.pictures.film import write_film

        write_film([np.full((4, 4), n - 1.0) for n in range(3)], folder / "film.mp4")
        yield from bytes_changed("film.mp4", (folder / "film.mp4").read_bytes(), count)
    for head in (npy_head((10**12, 9)), npy_head((2**62, 2**62)), npy_head((-1, 9)), npy_head((2, 2), "|O"), b"",
                 b"\x93NUMPY\x01\x00\x10\x00{'descr': (((((", b"\x93NUMPY\x02\x00\xff\xff\xff\x7f{"):  # fmt: skip
        yield "large.npy", head
    yield from bytes_changed("large.npy", npy_head((8, 8)) + np.linspace(-1, 1, 64).tobytes(), count)
    wrong: list[Any] = [None, -1, 10**18, [], {}, "x", [10**9] * 2, [[1]], [-1, 4], [{"name": "gzip"}], np.nan]
    for key in ZARR:
        for value in wrong:
            yield "zarr.json", json.dumps({**ZARR, key: value}).encode()
        yield "zarr.json", json.dumps({one: value for one, value in ZARR.items() if one != key}).encode()
    yield "zarr.json", b"[" * 100_000
    yield from bytes_changed("zarr.json", json.dumps(ZARR).encode(), count)
