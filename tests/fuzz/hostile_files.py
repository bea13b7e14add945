"""Hostile files: small ones that unpack to gigabytes, heads of huge sizes, deep nesting, millions of entries."""

import json
import struct
import zlib
from collections.abc import Iterator
from typing import Any

import numpy as np

from tests.fuzz.good_files import TEXTS, npy_head, npz, stl
from tests.fuzz.packed_zeros import zipped, zlib_zeros, zstd_zeros

Files = Iterator[tuple[str, bytes]]
HEAD = """# tactile_recording = 1
# title = "t"
# [[finger]]
# name = "tip"
# rows = {rows}
# cols = {cols}
# pitch_m = 0.001
# depth_m = 0.001
# quantity = "force"
t_s,t_device_s,finger,sequence,x0,y0,n0,x1,y1,n1,x2,y2,n2,x3,y3,n3
"""


def hostile_files() -> Files:
    """Yield the name and the bytes of each file."""
    yield from _texts()
    yield from _arrays()
    yield from _foreign()
    yield from _pictures()
    yield from _recordings()


def _texts() -> Files:
    for name in ("scene.toml", "template.toml", "program.toml", "array.toml", "calibration.toml", "truth.toml"):
        text = TEXTS[name]
        for more in ("a." * 3000 + "b = 1", "x = " + "[" * 5000, "x = " + "{a=" * 3000, "aliases = 1", "\0"):
            yield name, f"{more}\n{text}".encode()
        yield name, text.encode("utf-16")
        yield name, (text + "\n[[step]]" * 10_000).encode()
        yield name, b"#" + b"x" * 4_000_000
    for name in ("labels.csv", "slide_labels.csv", "weights.csv"):
        head, row, *_ = TEXTS[name].splitlines()
        for text in ("", head, head + '\n"' + "x" * 200_000, "," * 100_000, head + ",extra\n" + row, "\ufeff" + head,
                     head + "\n" + "1,2,3\n" * 100_000, head + "\n" + row + ",1,2,3", "\0" * 1000):  # fmt: skip
            yield name, text.encode()


def _arrays() -> Files:
    heads = (npy_head((10**12, 9, 3)), npy_head((2**62, 2**62)), npy_head((-1, 9)), npy_head((2, 2), "|O"), b"",
             b"\x93NUMPY\x01\x00\x10\x00{'descr': (((((", b"\x93NUMPY\x02\x00\xff\xff\xff\x7f{",
             npy_head((1, 9, 3), "<U99999999"), npy_head((3, 3)) + np.full(9, np.nan).tobytes(),
             npy_head((40_000_000, 9, 3)) + bytes(20_000_000))  # fmt: skip
    clock = npy_head((1,), "<i8") + bytes(8)
    for head in heads:
        for name in ("r.npy", "large.npy", "heights.npy", "traction.npy"):
            yield name, head
        yield "r.npz", npz(s0_t_ns=clock, s0_force=head, tactile=head)
        for name, key in (("model.npz", "names"), ("slides.npz", "force"), ("sequences.npz", "signal")):
            yield name, npz(**{key: head})
    for name in ("r.npz", "model.npz", "slides.npz", "sequences.npz"):
        yield name, zipped("s0_force.npy", 4_000_000_000, npy_head((4_000_000_000 // 216, 9, 3)))
    for text in ("vertex " * 100_000, "vertex 1e999 0 0\n" * 3, "vertex nan 0 0\n" * 3, "vertex 0 0 0\n" * 300_000):
        yield "body.stl", text.encode()
    for size in (1e-30, 1e9, 3e37):
        yield "body.stl", stl(np.full((4, 3, 3), size) * np.arange(9).reshape(3, 3))
    yield "body.stl", bytes(80) + (2**32 - 1).to_bytes(4, "little") + bytes(500)
    table = json.loads(TEXTS["zarr.json"])
    for key in table:
        values: list[Any] = [None, -1, 10**18, [], {}, "x", [10**9] * 2, [-1, 4], [{"name": "gzip"}]]
        for value in values:
            yield "zarr.json", json.dumps({**table, key: value}).encode()


def _foreign() -> Files:
    yield "t.m", b"".join(b"A%d_A = [1 2 3];\n" % n for n in range(1_000_000))
    yield "t.m", b"X_A = [" + b"1 " * 2_000_000 + b"];"
    yield "t.m", b"X_A = " + b"(" * 100_000
    yield "t.m", b"X_A = " + b"-" * 2_000_000 + b"1;"
    yield "t.m", b"X_A = 1" + b"+1" * 1_000_000
    yield "t.m", b"X_A = [1" + b";1" * 1_000_000 + b"]; Y_A = X_A*X_A;"
    yield "t.gene", (b"1 " * 19 + b"\n") * 200_000
    yield "t.gene", b"9" * 1_000_000
    yield "t.json", b"[" * 1_000_000
    yield "t.json", b'{"a":' * 100_000
    yield "t.json", json.dumps({"templates": [{"name": "x", "feedback": [[1]], "control": [[1]]}] * 100_000}).encode()
    yield "t.json", json.dumps({"name": "\x1b[2J../../x", "feedback": [[1e308] * 3] * 3, "control": [[1]]}).encode()
    yield "t.cnnsim", b"A\n" + b"1 " * 2_000_000
    for text in ("NEIGHBORHOOD: 1000000000\n", "FEEDBACK: " + "1 " * 10**6, "A" * 10**6, "\0" * 10**6):
        yield "t.tem", text.encode()


def _pictures() -> Files:
    yield "p.pgm", b"P5 1000000000 1000000000 255\n"
    yield "p.pgm", b"P5 " + b"9" * 10_000
    head = struct.pack(">IIBBBBB", 30_000, 29_999, 8, 0, 0, 0, 0)
    chunks = [(b"IHDR", head), (b"IDAT", zlib_zeros(30_001 * 30_000)), (b"IEND", b"")]
    packed = (struct.pack(">I", len(d)) + kind + d + struct.pack(">I", zlib.crc32(kind + d)) for kind, d in chunks)
    yield "p.png", b"\x89PNG\r\n\x1a\n" + b"".join(packed)


def _recordings() -> Files:
    for rows, cols in ((2, "9000000000000000000"), ("1e9", 2), (2**16, 2**16), (-1, 2)):
        for body in ("", "," * 10**6, '"' * 5000, "1e999,,tip"):
            yield "r.csv", (HEAD.format(rows=rows, cols=cols) + body).encode()
    ones = ",1" * 12
    for row in (f"nan,,tip,0{ones}", f"0,,tip,1e99{ones}", f"0,,tip,{'9' * 5000}{ones}", f"0,,\x1b[2J,0{ones}",
                f"0,1e999,tip,0{',1e999' * 12}", f"0,,tip,{2**70}{ones}"):  # fmt: skip
        yield "r.csv", f"{HEAD.format(rows=2, cols=2)}{row}\n{row}\n".encode()
    magic, start = b"\x89MCAP0\r\n", b"\x01" + struct.pack("<Q", 8) + bytes(8)
    for kind, size, data in ((b"zstd", 2**62, zstd_zeros(4_000_000_000)), (b"zstd", 100, zstd_zeros(4_000_000_000)),
                             (b"lz4", 2**40, b"aaaaa"), (b"\xff", 2**40, b"aaaaa")):  # fmt: skip
        chunk = struct.pack("<QQQII", 0, 0, size, 0, len(kind)) + kind + struct.pack("<Q", len(data)) + data
        yield "r.mcap", magic + start + b"\x06" + struct.pack("<Q", len(chunk)) + chunk
    yield "r.mcap", magic + b"\x05" + struct.pack("<Q", 2**60)
    bag = b"#ROSBAG V2.0\n"
    for rest in (b"", b"\xff" * 100, struct.pack("<I", 2**31) + b"x" * 100, b"\0" * 4096,
                 struct.pack("<I", 69) + b"\x11\0\0\0chunk_count=\xff\xff\xff\x7f" + b"\0" * 5000):  # fmt: skip
        yield "b.bag", bag + rest
    for text in (b"a: " + b"[" * 5000, b"a: &a [x]\nb: [" + b"*a," * 10_000 + b"]", b"!!python/object/apply:id [x]"):
        yield "metadata.yaml", text
