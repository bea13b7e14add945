"""Broken and hostile files of every kind that is read: cut short, changed, of wrong types, huge in few bytes."""

import io
import json
import random
import struct
import zipfile
import zlib
from collections.abc import Callable
from pathlib import Path

import numpy as np
from numpy.lib import format as npy

from tests.fuzz.broken_bags import bag, bag_files
from tests.fuzz.broken_texts import TEXTS, Broken, toml_files

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


TEM = b"NEIGHBORHOOD: 1\n\nFEEDBACK:\n0 1 0\n2 3 -4\n0 5 0\n\nCONTROL:\n0 0 0\n0 6 0\n0 0 0\nCURRENT: -7\n"
CNNSIM = b"A 0 1 0 2 3 -4 0 5 0\nB 0 0 0 0 6 0 0 0 0\nZ -7\nC ZeroFlux\n"


def bytes_changed(name: str, data: bytes, count: int, seed: int = 0) -> Broken:
    """A file cut short, with bytes changed, and followed by others."""
    rng = random.Random(seed)
    for _ in range(count):
        at = rng.randrange(len(data))
        yield name, data[:at]
        changed = bytearray(data)
        for _ in range(rng.choice((1, 1, 4, 64))):
            changed[rng.randrange(len(changed))] = rng.randrange(256)
        yield name, bytes(changed)
        yield name, data[:at] + rng.randbytes(64) + data[at:]
    yield name, b""
    yield name, rng.randbytes(3000)


def frames(count: int = 20) -> Callable[[Path], None]:
    """Return what writes a recording of a few frames in any form."""
    from tactile.core.frame import Frame, TaxelArray
    from tactile.core.source import FrameStream
    from tactile.sources.convert import WRITERS

    array = TaxelArray("tip", 2, 2, 1e-3, 1e-3, quantity="force")
    some = [Frame(0, 0.01 * n, n, np.full((2, 2, 3), float(n)), np.ones((2, 2), bool)) for n in range(count)]

    def write(path: Path) -> None:
        WRITERS[path.suffix](path, FrameStream("t", (array,), None, count, some))

    return write


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
    bomb = io.BytesIO()
    with (
        zipfile.ZipFile(bomb, "w", zipfile.ZIP_DEFLATED) as archive,
        archive.open("s0_force.npy", "w", force_zip64=True) as member,
    ):
        member.write(npy_head((4_000_000_000 // 216, 9, 3)))
        for _ in range(400):
            member.write(bytes(10_000_000))
    yield "bomb.npz", bomb.getvalue()


def csv_files() -> Broken:
    """Recordings in text: arrays of 10^18 columns, cells that are no numbers, lines without an end."""
    for rows, cols in ((2, "9000000000000000000"), ("1e9", 2), (2**16, 2**16), (-1, 2), (2, 2)):
        head = "".join(f"# {line}\n" for line in HEADER.format(rows=rows, cols=cols).splitlines())
        for body in (
            "",
            "t_s,t_device_s,finger,sequence,flags,x0,y0,n0\n",
            "\0" * 1000,
            '"' * 5000,
            "," * 10**6,
            "1e999,,tip",
        ):
            yield "r.csv", (head + body).encode()
    good = ",".join(["t_s,t_device_s,finger,sequence", *(f"x{n},y{n},n{n}" for n in range(4))])
    head = "".join(f"# {line}\n" for line in HEADER.format(rows=2, cols=2).splitlines())
    for row in ("nan,,tip,0" + ",1" * 12, "0,,tip,1e99" + ",1" * 12, "0,,tip," + "9" * 5000 + ",1" * 12,
                "0,,tip,0" + ",x" * 12, "0,,\x1b[2J,0" + ",1" * 12, "0,1e999,tip,0" + ",1e999" * 12,
                "1e308,,tip,0" + ",1" * 12, "0,,tip,-5" + ",1" * 12, "0,,tip," + str(2**70) + ",1" * 12):  # fmt: skip
        yield "r.csv", f"{head}{good}\n{row}\n{row}\n".encode()


def foreign_files() -> Broken:
    """Template files of other systems: 10^6 entries, deep brackets, numbers without end, other types."""
    yield "t.m", b"".join(b"A%d_A = [1 2 3];\n" % n for n in range(10_000))
    yield "t.m", b"".join(b"A%d_A = [1 2 3];\n" % n for n in range(1_000_000))
    yield "t.m", b"X_A = [" + b"1 " * 100_000 + b"];"
    yield "t.m", b"X_A = 1" + b"+1" * 100_000
    yield "t.m", b"X_A = [" + b"1 " * 2_000_000 + b"];"
    yield "t.m", b"X_A = " + b"(" * 100_000
    yield "t.m", b"X_A = " + b"-" * 2_000_000 + b"1;"
    yield "t.m", b"X_A = 1" + b"+1" * 1_000_000
    yield "t.m", b"X_A = [1" + b";1" * 1_000_000 + b"]; Y_A = X_A*X_A;"
    yield "t.gene", b"1 " * 19 + b"\n" + (b"1 " * 19 + b"\n") * 200_000
    yield "t.gene", b"9" * 1_000_000
    yield "t.json", b"[" * 1_000_000
    yield "t.json", b'{"a":' * 100_000
    yield "t.json", json.dumps({"templates": [{"name": "x", "feedback": [[1]], "control": [[1]]}] * 100_000}).encode()
    yield "t.json", json.dumps({"name": "\x1b[2J../../x", "feedback": [[1e308] * 3] * 3, "control": [[1]]}).encode()
    yield "t.json", b'{"name": "x", "feedback": [[' + b"9" * 1_000_000 + b']], "control": [[1]]}'
    yield "t.cnnsim", b"A " * 1_000_000
    yield "t.cnnsim", b"A\n" + b"1 " * 2_000_000
    for text in (
        "NEIGHBORHOOD: 1000000000\n",
        "NEIGHBORHOOD: -1\n",
        "FEEDBACK: " + "1 " * 10**6,
        "A" * 10**6,
        "\0" * 10**6,
    ):
        yield "t.tem", text.encode()


def picture_files(count: int) -> Broken:
    """Pictures: heads of 10^9 x 10^9 pixels, chunks that end nowhere, and what Pillow trips over."""
    from PIL import Image

    for form, name in (("PNG", "p.png"), ("GIF", "p.gif"), ("BMP", "p.bmp"), ("TIFF", "p.tif"), ("JPEG", "p.jpg"),
                       ("PPM", "p.pgm")):  # fmt: skip
        out = io.BytesIO()
        Image.fromarray(np.arange(64 * 64, dtype=np.uint16).astype(np.uint8).reshape(64, 64)).save(out, format=form)
        yield from bytes_changed(name, out.getvalue(), count)
        big = bytearray(out.getvalue())
        places = {"PNG": 16, "BMP": 18, "GIF": 6}
        if form in places:
            big[places[form] : places[form] + 4] = b"\x3f" * 4
            yield name, bytes(big)
    yield "p.pgm", b"P5 1000000000 1000000000 255\n"
    yield "p.pgm", b"P5 " + b"9" * 10_000
    head = struct.pack(">IIBBBBB", 30_000, 30_000, 8, 0, 0, 0, 0)
    pack = zlib.compressobj(9)
    rows = b"".join(pack.compress(bytes(30_001)) for _ in range(30_000)) + pack.flush()
    chunks = [(b"IHDR", head), (b"IDAT", rows), (b"IEND", b"")]
    yield (
        "bomb.png",
        b"\x89PNG\r\n\x1a\n"
        + b"".join(
            struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))
            for kind, data in chunks
        ),
    )


def mcap_files() -> Broken:
    """MCAP files whose chunks unpack to gigabytes, or say that they do."""
    import zstandard

    magic = b"\x89MCAP0\r\n"

    def text(value: bytes) -> bytes:
        return struct.pack("<I", len(value)) + value

    def record(op: int, body: bytes) -> bytes:
        return bytes([op]) + struct.pack("<Q", len(body)) + body

    out = io.BytesIO()
    with zstandard.ZstdCompressor(level=3).stream_writer(out, closefd=False) as file:
        for _ in range(400):
            file.write(bytes(10_000_000))
    packed = out.getvalue()
    for said in (4_000_000_000, 100, 2**62):
        body = struct.pack("<QQQI", 0, 0, said, 0) + text(b"zstd") + struct.pack("<Q", len(packed)) + packed
        yield "bomb.mcap", magic + record(1, text(b"") * 2) + record(6, body)
    for kind in (b"lz4", b"", b"none", b"\xff"):
        body = struct.pack("<QQQI", 0, 0, 2**40, 0) + text(kind) + struct.pack("<Q", 5) + b"aaaaa"
        yield "r.mcap", magic + record(1, text(b"") * 2) + record(6, body)
    yield "r.mcap", magic + b"\x05" + struct.pack("<Q", 2**60)
    yield "r.mcap", magic + b"\x05" + struct.pack("<Q", 2**27) + b"\0" * 100


def all_files(folder: Path, count: int) -> Broken:
    """Yield them all, and three times ``count`` changes of a good file of every kind."""
    yield from toml_files()
    yield from array_files()
    yield from csv_files()
    yield from foreign_files()
    yield from picture_files(count)
    yield from bag_files()
    yield from mcap_files()
    yield from bytes_changed("b.bag", bag(folder), count)
    yield from bytes_changed("r.npy", npy_head((4, 4)) + np.linspace(-1, 1, 16).tobytes(), count)
    yield from bytes_changed("t.tem", TEM, count)
    yield from bytes_changed("t.cnnsim", CNNSIM, count)
    write = frames()
    for suffix in (".csv", ".npz", ".parquet", ".mcap"):
        path = folder / f"good{suffix}"
        write(path)
        yield from bytes_changed(f"r{suffix}", path.read_bytes(), count)
    json_text = b'{"name": "x", "feedback": [[1]], "control": [[2]], "bias": 1, "tags": ["a"]}'
    matlab = b"X_A = [1 2 1; 0 1 0; 0 0 0];\nX_B = [1]; X_I = -1;\n"
    for kind, words in TEXTS.items():
        yield from bytes_changed(kind, words.encode(), count)
    for name, text in (("t.m", matlab), ("t.gene", b"1 " * 19), ("t.json", json_text)):
        yield from bytes_changed(name, text, count)
