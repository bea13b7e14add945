"""The files that documentation and help texts name as the user's own."""

import re
from importlib.util import find_spec
from pathlib import Path

import numpy as np

from cnnsim import write_picture
from cnnsim.support.pictures.film import write_film
from tactile.core.frame import Frame, TaxelArray
from tactile.core.source import FrameStream
from tactile.sources.convert import convert
from tactile.sources.replay_npz import write_npz
from tests.kits.example_files import RECORDING, SCENE, scan
from tests.kits.formats import HOLE
from tests.kits.paths import ROOT, SCENES
from tests.kits.touch.sequences import write_sequences
from tests.kits.touch.slides import slides, write_slides

TEMLIB = "RIM_A = [0 0 0; 0 1 0; 0 0 0];\nRIM_B = [-1 -1 -1; -1 8 -1; -1 -1 -1];\nRIM_I = -1;\n"
GENE = "-1 -1 -1 -1 -1 8 -1 -1 -1 -1 0 0 0 0 1 0 0 0 0\n"
RULE = 'black = [["???", "?#?", "???"]]\ndefault = "white"\n'
LABELS = "recording,sensor,contact_s,release_s\n" + "".join(
    f"{name},{sensor},0.4,5.2\n" for name in ("again", "grasp") for sensor in (0, 1)
)
PROGRAM = """
name = "my-program"
llm = ["a", "b", "mask", "changed"]
inputs = ["a", "b", "mask"]
outputs = ["changed"]
step = [
  { logic = "xor", of = ["a", "b"], to = "changed" },
  { logic = "and", of = ["changed", "mask"], to = "changed" },
]
"""

STUDY = """
kind = "transients"
[grid]
template = ["edge", "hole-filler"]
density = [0.3, 0.6]
seed = { from = 0, count = 2 }
[fixed]
rows = 12
"""
GRIPS = """
kind = "scenes"
[grid]
seed = [1, 2]
[fixed]
scene = "scene.toml"
rate_hz = 20
"""


GLOVE = "t;x0;y0;z0;x1;y1;z1\n" + "".join(f"{n / 100};0,1;0,2;{n % 7};0,1;0,2;{n % 5}\n" for n in range(40))
GLOVE_LAYOUT = """
[layout]
time = "t"
[[finger]]
name = "glove"
rows = 1
cols = 2
pitch_mm = 4.0
depth_mm = 0.0
quantity = "force"
columns = "{axis}{taxel}"
"""


def detector() -> str:
    """Return the detector of docs/detectors.md."""
    (text,) = re.findall(
        r"^```toml\n(name +=.*?)^```", (ROOT / "docs" / "detectors.md").read_text("utf-8"), re.M | re.S
    )
    return str(text)


def write_own_files(folder: Path) -> None:
    """Write all files into a folder."""
    square, picture = np.pad(np.ones((9, 9)), 5, constant_values=-1), scan()[::2, ::2]
    for name in ("square", "before", "after"):
        write_picture(square if name != "after" else -square, folder / f"{name}.png")
    for name in ("scan.png", "photo.jpg", "photo.png", "f1.png", "f2.png", "frame1.png", "frame2.png", "frame3.png"):
        write_picture(picture, folder / name)
    for name in ("mask", "marker", "keep"):
        write_picture(abs(picture) * (1 if name == "mask" else -1), folder / f"{name}.png")
    for name in ("scans", "left", "right"):
        (folder / name).mkdir()
        for number in (1, 2):
            write_picture(np.roll(picture, number, axis=1), folder / name / f"{number}.png")
    if find_spec("av") is not None:
        write_film([np.roll(picture, number, axis=1) for number in range(4)], folder / "walk.mp4")
    texts = {
        "EDGE.tem": HOLE.replace("HoleFiller", "Edge"), "HOLE.tem": HOLE, "temlib.m": TEMLIB, "best.txt": GENE,
        "rule.toml": RULE, "my-program.toml": PROGRAM, "two-blobs.toml": detector(), "l.csv": LABELS,
        "study.toml": STUDY, "grips.toml": GRIPS, "glove.csv": GLOVE, "glove.toml": GLOVE_LAYOUT,
    }  # fmt: skip
    for name, text in texts.items():
        (folder / name).write_text(text, encoding="utf-8")
    (folder / "grasps").mkdir()
    (folder / "grasps" / "labels.csv").write_text(LABELS, encoding="utf-8")
    for path in (folder / name for name in ("grasp.npz", "again.npz", "grasps/grasp.npz", "grasps/again.npz")):
        path.write_bytes(RECORDING.read_bytes())
    (folder / "scene.toml").write_bytes(SCENE.read_bytes())
    (folder / "slides").mkdir()
    write_slides(folder / "slides" / "slides.npz", slides(3, ("screw", "rasp", "smooth wood"), 300))
    write_weights(folder)
    write_sequences(folder)
    for name in ("scan.csv", "scan.npz", "grasp.csv"):
        convert(SCENES / "needle.toml", folder / name)


def write_weights(folder: Path) -> None:
    """Write pad.npz, 20 successive weights on four force taxels, and weights.csv with their times and forces."""
    random, pad = np.random.default_rng(1), TaxelArray("pad", 2, 2, 4e-3, 0.0, quantity="force")
    shares = np.concatenate([np.zeros((100, 4)), np.repeat(random.dirichlet(np.ones(4), 20), 20, axis=0)])
    pull = np.repeat(np.vstack([np.zeros((5, 3)), random.uniform(0.2, 1, (20, 3))]), 20, axis=0)
    values = (shares[:, :, None] * pull[:, None]).reshape(-1, 2, 2, 3) + random.normal(size=(500, 2, 2, 3)) * 1e-4
    frames = [Frame(0, n / 100, n, one, np.ones((2, 2), bool)) for n, one in enumerate(values)]
    write_npz(folder / "pad.npz", FrameStream("pad", (pad,), None, len(frames), frames))
    rows = [f"{1 + 0.2 * k},{1.19 + 0.2 * k},{q},{r},{f}" for k, (q, r, f) in enumerate(pull[100::20].tolist())]
    (folder / "weights.csv").write_text("\n".join(["from_s,to_s,q_n,r_n,f_n", *rows]) + "\n", encoding="utf-8")
