"""Good files of every kind that is read, which hypothesis changes, and the values that it writes into their texts."""

import io
import json
import zipfile
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import numpy as np
from numpy.lib import format as npy
from PIL import Image

from tests.kits.paths import ROOT, SCENES

HUGE = ("1e9", "9223372036854775807", "1e308", "1e-300", "-1", "0", "nan", "inf", '"x"', "true", "[]", "{}", "[[]]",
        "1979-05-27", "9" * 400, '"' + "x" * 10000 + '"', '"\\u001b[2J"', '"../x"', "[1e308, 1e308]")  # fmt: skip
ARRAY = """
title = "hand"
protocol = "native"
baudrate = 115200
youngs_modulus_mpa = 0.4
[[finger]]
name = "thumb"
rows = 2
cols = 2
pitch_mm = 7.0
depth_mm = 2.0
origin_mm = [0.0, 0.0]
quantity = "strain"
axes = ["x", "y", "-z"]
gains = [1e-5, 2e-5]
cells = [[0, 1], [2, 3]]
"""
CALIBRATION = """
shear_gain = 1.0
normal_gain = 2.0
depth_mm = 1.5
[radial]
located_um = [0.0, 100.0, 200.0]
true_um = [0.0, 110.0, 220.0]
force_factor = [1.0, 1.0, 1.0]
"""
TEXTS = {
    "scene.toml": (SCENES / "grip.toml").read_text(encoding="utf-8"),
    "template.toml": (ROOT / "templates" / "edge.toml").read_text(encoding="utf-8"),
    "program.toml": (ROOT / "templates" / "programs" / "count-objects.toml").read_text(encoding="utf-8"),
    "array.toml": ARRAY, "calibration.toml": CALIBRATION,
    "truth.toml": 'black = [["###", "###", "###"]]\nwhite = [["...", "...", "..."]]\ndefault = "black"\n',
    "labels.csv": "recording,sensor,contact_s,release_s\na,0,1.0,2.0\nb,1,,\n",
    "slide_labels.csv": "recording,material,sensor,start_s,stop_s,speed_mm_s,block\na,oak,0,1.0,2.0,10,1\nb,oak,,,,,\n",
    "weights.csv": "from_s,to_s,grams,x_mm,y_mm\n0.0,1.0,100,0.0,0.0\n2.0,3.0,200,1.0,0.5\n",
    "t.m": "X_A = [1 2 1; 0 1 0; 0 0 0];\nX_B = [1]; X_I = -1;\n", "t.gene": "1 " * 19,
    "t.json": '{"name": "x", "feedback": [[1]], "control": [[2]], "bias": 1, "tags": ["a"]}',
    "t.tem": "NEIGHBORHOOD: 1\n\nFEEDBACK:\n0 1 0\n2 3 -4\n0 5 0\n\nCONTROL:\n0 0 0\n0 6 0\n0 0 0\nCURRENT: -7\n",
    "t.cnnsim": "A 0 1 0 2 3 -4 0 5 0\nB 0 0 0 0 6 0 0 0 0\nZ -7\nC ZeroFlux\n",
    "zarr.json": json.dumps({
        "zarr_format": 3, "node_type": "array", "shape": [8, 8], "data_type": "float32",
        "chunk_grid": {"name": "regular", "configuration": {"chunk_shape": [8, 8]}},
        "chunk_key_encoding": {"name": "default", "configuration": {"separator": "/"}}, "fill_value": 0,
        "codecs": [{"name": "bytes", "configuration": {"endian": "little"}}], "attributes": {},
    }),
}  # fmt: skip
PILLAR = "float32 fX\nfloat32 fY\nfloat32 fZ\n"
STATE = "int64 tus\npapillarray_ros_v2/PillarState[] pillars\n"


def npz(**arrays: bytes) -> bytes:
    """Return an archive of raw members."""
    out = io.BytesIO()
    with zipfile.ZipFile(out, "w", zipfile.ZIP_DEFLATED) as archive:
        for name, data in arrays.items():
            archive.writestr(f"{name}.npy", data)
    return out.getvalue()


def npy_head(shape: tuple[int, ...], kind: str = "<f8") -> bytes:
    """Return the head of an .npy file, without its numbers."""
    out = io.BytesIO()
    npy.write_array_header_1_0(out, {"descr": kind, "fortran_order": False, "shape": shape})
    return out.getvalue()


def _saved(**arrays: Any) -> bytes:
    out = io.BytesIO()
    np.savez_compressed(out, **arrays)
    return out.getvalue()


def _recording(path: Path) -> bytes:
    """Return a recording of 20 frames; all values of frame n are n."""
    from tactile.core.frame import Frame, TaxelArray
    from tactile.core.source import FrameStream
    from tactile.sources.convert import WRITERS

    array = TaxelArray("tip", 2, 2, 1e-3, 1e-3, quantity="force")
    some = [Frame(0, 0.01 * n, n, np.full((2, 2, 3), float(n)), np.ones((2, 2), bool)) for n in range(20)]
    WRITERS[path.suffix](path, FrameStream("t", (array,), None, 20, some))
    return path.read_bytes()


def _picture(form: str) -> bytes:
    out = io.BytesIO()
    Image.fromarray(np.arange(4096, dtype=np.uint16).astype(np.uint8).reshape(64, 64)).save(out, format=form)
    return out.getvalue()


def stl(triangles: Any) -> bytes:
    """Return a binary STL file of triangles (n, 3, 3)."""
    rows = np.zeros(len(triangles), np.dtype([("n", "<f4", 3), ("at", "<f4", (3, 3)), ("more", "<u2")]))
    rows["at"] = triangles
    return bytes(80) + len(rows).to_bytes(4, "little") + rows.tobytes()


def _model(path: Path) -> bytes:
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
    return path.read_bytes()


def _bag(folder: Path, ros: int) -> bytes:
    """Return a bag of a pillar sensor with 5 messages; of ROS 2 its data base, with its description in the folder."""
    from rosbags import rosbag1, rosbag2
    from rosbags.typesys import Stores, get_types_from_msg, get_typestore

    store = get_typestore(Stores.ROS1_NOETIC if ros == 1 else Stores.ROS2_HUMBLE)
    kinds = {"papillarray_ros_v2/msg/PillarState": PILLAR, "papillarray_ros_v2/msg/SensorState": STATE}
    for kind, text in kinds.items():
        store.register(get_types_from_msg(text, kind))
    pillar, state = (store.types[kind] for kind in kinds)
    writer: Any = rosbag1.Writer(folder / "one.bag") if ros == 1 else rosbag2.Writer(folder / "good", version=8)
    with writer:
        topic = writer.add_connection("/s", kind, typestore=store)
        for n in range(5):
            message = state(n, [pillar(n, 0, 1)] * 4)
            data = store.serialize_ros1(message, kind) if ros == 1 else store.serialize_cdr(message, kind)
            writer.write(topic, 51_000_000_000 + 1_000_000 * n, data)
    if ros == 1:
        return (folder / "one.bag").read_bytes()
    (folder / "metadata.yaml").write_bytes((folder / "good" / "metadata.yaml").read_bytes())
    return (folder / "good" / "good.db3").read_bytes()


def good_files(folder: Path) -> dict[str, bytes]:
    """Return a good file of each kind by its name, which chooses its reader."""
    rng = np.random.default_rng(0)
    found = {name: text.encode() for name, text in TEXTS.items()}
    for kind in ("csv", "npz", "parquet", "mcap"):
        found[f"r.{kind}"] = _recording(folder / f"r.{kind}")
    for form, name in (("PNG", "p.png"), ("GIF", "p.gif"), ("BMP", "p.bmp"), ("TIFF", "p.tif"), ("JPEG", "p.jpg"),
                       ("PPM", "p.pgm")):  # fmt: skip
        found[name] = _picture(form)
    found["r.npy"] = npy_head((4, 4)) + np.linspace(-1, 1, 16).tobytes()
    found["large.npy"] = npy_head((8, 8)) + np.linspace(-1, 1, 64).tobytes()
    found["heights.npy"] = npy_head((8, 8)) + rng.random(64).tobytes()
    found["traction.npy"] = npy_head((4, 4, 3)) + rng.random(48).tobytes()
    found["body.stl"] = stl(rng.normal(size=(8, 3, 3)))
    found["model.npz"] = _model(folder / "model.npz")
    found["slides.npz"] = _saved(
        force=rng.normal(size=(60, 3)), length=np.array([30, 30]), t=np.arange(60) * 0.01,
        material=np.array(["a", "b"]), repeat=np.array([0, 1]), speed_m_s=np.array([0.1, 0.1]),
    )  # fmt: skip
    found["sequences.npz"] = _saved(
        signal=rng.normal(size=(2, 90, 6)), slip=np.array([True, False]), rate_hz=np.array(100.0),
        onset_s=np.array([0.5, np.nan]),
    )  # fmt: skip
    found["b.bag"], found["good.db3"] = _bag(folder, 1), _bag(folder, 2)
    found["metadata.yaml"] = (folder / "metadata.yaml").read_bytes()
    if find_spec("av"):
        from cnnsim.support.pictures.film import write_film

        write_film([np.full((4, 4), n - 1.0) for n in range(3)], folder / "film.mp4")
        found["film.mp4"] = (folder / "film.mp4").read_bytes()
    return found
