"""Broken and hostile files of every kind that is read: cut short, changed, of wrong types, huge in few bytes."""

import io
import json
import struct
import zlib
from collections.abc import Callable
from pathlib import Path

import numpy as np

from tests.fuzz.broken_arrays import HEADER, array_files, npy_head, side_files
from tests.fuzz.broken_bags import bags
from tests.fuzz.broken_tables import large_files, table_files
from tests.fuzz.broken_texts import TEXTS, Broken, toml_files
from tests.fuzz.changed_bytes import bytes_changed
from tests.fuzz.packed_zeros import zlib_zeros, zstd_zeros

TEM = b"NEIGHBORHOOD: 1\n\nFEEDBACK:\n0 1 0\n2 3 -4\n0 5 0\n\nCONTROL:\n0 0 0\n0 6 0\n0 0 0\nCURRENT: -7\n"
CNNSIM = b"A 0 1 0 2 3 -4 0 5 0\nB 0 0 0 0 6 0 0 0 0\nZ -7\nC ZeroFlux\n"


def frames(path: Path, count: int = 20) -> bytes:
    """Return a recording of a few frames in the form that a path's suffix says; frame n holds n everywhere."""
    from tactile.core.frame import Frame, TaxelArray
    from tactile.core.source import FrameStream
    from tactile.sources.convert import WRITERS

    array = TaxelArray("tip", 2, 2, 1e-3, 1e-3, quantity="force")
    some = [Frame(0, 0.01 * n, n, np.full((2, 2, 3), float(n)), np.ones((2, 2), bool)) for n in range(count)]
    path.unlink(missing_ok=True)
    WRITERS[path.suffix](path, FrameStream("t", (array,), None, count, some))
    data = path.read_bytes()
    path.unlink()
    return data


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
    head = struct.pack(">IIBBBBB", 30_000, 29_999, 8, 0, 0, 0, 0)
    rows = zlib_zeros(30_001 * 30_000)
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
    magic = b"\x89MCAP0\r\n"

    def text(value: bytes) -> bytes:
        return struct.pack("<I", len(value)) + value

    def record(op: int, body: bytes) -> bytes:
        return bytes([op]) + struct.pack("<Q", len(body)) + body

    packed = zstd_zeros(4_000_000_000)
    for said in (4_000_000_000, 100, 2**62):
        body = struct.pack("<QQQI", 0, 0, said, 0) + text(b"zstd") + struct.pack("<Q", len(packed)) + packed
        yield "bomb.mcap", magic + record(1, text(b"") * 2) + record(6, body)
    for kind in (b"lz4", b"", b"none", b"\xff"):
        body = struct.pack("<QQQI", 0, 0, 2**40, 0) + text(kind) + struct.pack("<Q", 5) + b"aaaaa"
        yield "r.mcap", magic + record(1, text(b"") * 2) + record(6, body)
    yield "r.mcap", magic + b"\x05" + struct.pack("<Q", 2**60)
    yield "r.mcap", magic + b"\x05" + struct.pack("<Q", 2**27) + b"\0" * 100


def recording_files(folder: Path, count: int) -> Broken:
    """Recordings that other libraries pack: MCAP and Parquet."""
    yield from mcap_files()
    for name in ("r.parquet", "r.mcap"):
        yield from bytes_changed(name, frames(folder / name), count)


def array_recordings(folder: Path, count: int) -> Broken:
    """Recordings and pictures as arrays."""
    yield from array_files()
    yield from bytes_changed("r.npy", npy_head((4, 4)) + np.linspace(-1, 1, 16).tobytes(), count)
    yield from bytes_changed("r.npz", frames(folder / "r.npz"), count)


def text_recordings(folder: Path, count: int) -> Broken:
    """Recordings as text."""
    yield from csv_files()
    yield from bytes_changed("r.csv", frames(folder / "r.csv"), count)


def foreign_templates(_folder: Path, count: int) -> Broken:
    """Templates of other systems."""
    yield from foreign_files()
    json_text = b'{"name": "x", "feedback": [[1]], "control": [[2]], "bias": 1, "tags": ["a"]}'
    matlab = b"X_A = [1 2 1; 0 1 0; 0 0 0];\nX_B = [1]; X_I = -1;\n"
    for name, text in (("t.m", matlab), ("t.gene", b"1 " * 19), ("t.json", json_text), ("t.tem", TEM),
                       ("t.cnnsim", CNNSIM)):  # fmt: skip
        yield from bytes_changed(name, text, count)


def texts(_folder: Path, count: int) -> Broken:
    """Files of TOML."""
    yield from toml_files()
    for kind, words in TEXTS.items():
        yield from bytes_changed(kind, words.encode(), count)


def pictures(_folder: Path, count: int) -> Broken:
    """Pictures of every kind."""
    yield from picture_files(count)


PARTS: dict[str, Callable[[Path, int], Broken]] = {
    "texts": texts, "arrays": array_recordings, "text-recordings": text_recordings, "foreign": foreign_templates,
    "pictures": pictures, "recordings": recording_files, "sides": side_files, "tables": table_files,
    "large": large_files, "bags": bags,
}  # fmt: skip
"""The parts, each of which gives the fixed files of its kinds and three times so many changes of a good one."""
