"""Broken archives and arrays of NumPy: recordings, pictures, models, slides, sequences, heights and tractions."""

import io
import zipfile
from pathlib import Path
from typing import Any

import numpy as np
from numpy.lib import format as npy

from tests.fuzz.broken_texts import Broken
from tests.fuzz.changed_bytes import bytes_changed
from tests.fuzz.packed_zeros import zipped

HEADER = """tactile_recording = 1
title = "t"
[[finger]]
name = "tip"
rows = {rows}
cols = {cols}
pitch_m = 0.001
depth_m = 0.001
quantity = "force"
"""


def npz(**arrays: bytes) -> bytes:
    """Return an archive of raw members."""
    out = io.BytesIO()
    with zipfile.ZipFile(out, "w", zipfile.ZIP_DEFLATED) as archive:
        for name, data in arrays.items():
            archive.writestr(f"{name}.npy", data)
    return out.getvalue()


def npy_head(shape: tuple[int, ...], kind: str = "<f8", order: bool = False) -> bytes:
    """Return the head of an .npy file of that shape, without its numbers."""
    out = io.BytesIO()
    npy.write_array_header_1_0(out, {"descr": kind, "fortran_order": order, "shape": shape})
    return out.getvalue()


def array_files() -> Broken:
    """Archives and arrays of NumPy: heads of 10^12 frames, zeros by the gigabyte, heads that are no heads, pickles."""
    zeros = npy_head((40_000_000, 9, 3)) + bytes(20_000_000)
    small = {"s0_t_ns": npy_head((1,), "<i8") + b"\0" * 8}
    for head in (npy_head((10**12, 9, 3)), npy_head((2**62, 2**62)), npy_head((-1, 9, 3)), zeros, b"\x93NUMPY\x01\x00",
                 b"\x93NUMPY\x01\x00\x10\x00{'descr': (((((", b"\x93NUMPY\x09\x00aaaa", npy_head((1, 9, 3), "|O"),
                 b"\x93NUMPY\x02\x00\xff\xff\xff\x7f{", npy_head((1, 9, 3), "<U99999999")):  # fmt: skip
        for name in ("force", "values"):
            yield "r.npz", npz(**small, **{f"s0_{name}": head}, tactile=head)
        yield "r.npy", head
    header = np.frombuffer(HEADER.format(rows=2**31, cols=2**31).encode(), "S1")
    yield "r.npz", npz(tactile=npy_head((), f"<U{header.size}") + "".join(map(chr, range(60))).encode("utf-32-le"))
    yield "bomb.npz", zipped("s0_force.npy", 4_000_000_000, npy_head((4_000_000_000 // 216, 9, 3)))


def sides(folder: Path) -> dict[str, bytes]:
    """Return good files of arrays that are no recordings: models, slides, sequences, heights, tractions, bodies."""
    rng = np.random.default_rng(0)
    _model(folder / "model.npz")
    slides = {
        "force": rng.normal(size=(60, 3)), "length": np.array([30, 30]), "t": np.arange(60) * 0.01,
        "material": np.array(["a", "b"]), "repeat": np.array([0, 1]), "speed_m_s": np.array([0.1, 0.1]),
    }  # fmt: skip
    sequences = {
        "signal": rng.normal(size=(2, 90, 6)), "slip": np.array([True, False]), "rate_hz": np.array(100.0),
        "onset_s": np.array([0.5, np.nan]),
    }  # fmt: skip
    triangle = struct_stl(rng.normal(size=(8, 3, 3)))
    return {
        "model.npz": (folder / "model.npz").read_bytes(), "slides.npz": _saved(slides),
        "sequences.npz": _saved(sequences), "heights.npy": npy_head((8, 8)) + rng.random(64).tobytes(),
        "traction.npy": npy_head((4, 4, 3)) + rng.random(48).tobytes(), "body.stl": triangle,
    }  # fmt: skip


def side_files(folder: Path, count: int) -> Broken:
    """Files of arrays that are no recordings: heads of huge shapes, other types, other arrays, and changed bytes."""
    heads = (npy_head((10**12, 9)), npy_head((2**62, 2**62)), npy_head((-1, 9)), npy_head((2, 2), "|O"), b"",
             npy_head((4, 4), "<U2") + "ab".encode("utf-32-le") * 16, npy_head(()) + b"\0" * 8,
             npy_head((3, 3)) + np.full(9, np.nan).tobytes(), npy_head((3, 3)) + np.full(9, 1e308).tobytes(),
             npy_head((2, 2), "<c16") + bytes(64), npy_head((2, 2), "<i8") + b"\xff" * 32,
             npy_head((3,), "<M8[s]") + bytes(24), npy_head((0, 3)))  # fmt: skip
    good = sides(folder)
    for name, data in good.items():
        for head in heads if name.endswith(".npy") else ():
            yield name, head
        if name.endswith(".npz"):
            with zipfile.ZipFile(io.BytesIO(data)) as archive:
                members = {one[:-4]: archive.read(one) for one in archive.namelist()}
            for key in members:
                yield name, npz(**{one: part for one, part in members.items() if one != key})
                for head in heads:
                    yield name, npz(**{**members, key: head})
            yield name, zipped(f"{next(iter(members))}.npy", 4_000_000_000, npy_head((500_000_000,)))
    for text in ("vertex " * 100_000, "vertex 1e999 0 0\n" * 3, "vertex 1 2\n" * 3, "vertex nan 0 0\n" * 3,
                 "vertex 1e300 0 0\nvertex 0 1e300 0\nvertex 0 0 1\n", "vertex 0 0 0\n" * 300_000):  # fmt: skip
        yield "body.stl", text.encode()
    for size in (1e-30, 1e9, 3e38):
        yield "body.stl", struct_stl(np.full((4, 3, 3), size) * np.arange(9).reshape(3, 3))
    yield "body.stl", bytes(80) + (2**32 - 1).to_bytes(4, "little") + bytes(500)
    for name, data in good.items():
        yield from bytes_changed(name, data, count)


def struct_stl(triangles: Any) -> bytes:
    """Return a binary STL file of triangles (n, 3, 3)."""
    rows = np.zeros(len(triangles), np.dtype([("n", "<f4", 3), ("at", "<f4", (3, 3)), ("more", "<u2")]))
    rows["at"] = triangles
    return bytes(80) + len(rows).to_bytes(4, "little") + rows.tobytes()


def _saved(arrays: dict[str, Any]) -> bytes:
    out = io.BytesIO()
    np.savez_compressed(out, **arrays)
    return out.getvalue()


def _model(path: Path) -> None:
    from tactile.materials.features import BANDS, FINE, FeatureSet
    from tactile.materials.model import Confidence, TextureModel
    from tactile.materials.model_file import write_model
    from tactile.materials.nearest_neighbours import KnownWindows, Space

    features = FeatureSet("figures", 100, np.linspace(1, 50, BANDS * FINE), 0.01)
    size, marks, wide = len(features.names), 3, 2
    rng = np.random.default_rng(1)
    space = Space(rng.random(size), rng.random(size), rng.random((marks, size)), rng.random((marks, marks)), 0.5, 0.5,
                  rng.random((size + marks, wide)))  # fmt: skip
    known = KnownWindows(rng.random((4, wide)), np.array([0, 0, 1, 1]), 2)
    write_model(path, TextureModel(("a", "b"), features, space, known, Confidence(0.1, 1.0, 1.0), {"rate_hz": 100.0}))
