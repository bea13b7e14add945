"""A valid file of every kind that users write, with nearly all keys, one per line, and its reader."""

from collections.abc import Callable
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

from cnnsim.library.read import load_file
from cnnsim.program.file import load_program
from cnnsim.support.toml_file import parse_toml
from tactile.calibration.file import parse_calibration
from tactile.events.detector_file import read_detector
from tactile.simulator.scene_file.file import scene_from
from tactile.wire.description_file import parse_description

DESCRIPTION = """\
title = "g"
protocol = "reskin"
baudrate = 115200
youngs_modulus_mpa = 0.4
[[finger]]
name = "thumb"
rows = 3
cols = 3
pitch_mm = 7.0
depth_mm = 2.0
thickness_mm = 3.0
origin_mm = [0, 0]
quantity = "strain"
axes = ["x", "y", "-z"]
gains = [1e-5, 2e-5]
cells = [[-1, 1, -1], [4, 0, 2], [-1, 3, -1]]
[[finger]]
name = "index"
rows = 2
cols = 2
pitch_mm = 7.0
depth_mm = 2.0
quantity = "strain"
[thresholds]
dead_band = 1e-3
hysteresis = 5e-4
contact_level = 1e-3
sigmas = [4, 6, 3]
"""
SCENE = """\
title = "s"
rate_hz = 100
duration_s = 2.0
seed = 3
accuracy = 0.001
[cover]
youngs_modulus_mpa = 2.4
quantity = "strain"
full_scale = 0.1
[[finger]]
name = "left"
rows = 2
cols = 2
pitch_mm = 1.5
depth_mm = 1.5
origin_mm = [0.0, 0.0]
[[load]]
finger = "left"
path = [[0.5, 0, 0, 0, 0, 0], [1.2, 0, 0, 0, 0, 0.6]]
[[contact]]
finger = "left"
shape = "cylinder"
radius_mm = 1
length_mm = 3
angle_deg = 3
friction = 0.3
given = "force"
path = [[0.5, 0, 0, 0, 0, 0], [1.2, 0, 0, 0, 0, 0.6]]
[[texture]]
finger = "left"
material = "rasp"
place_mm = [0, 0]
start_s = 0
stop_s = 1
speed_mm_s = 20
direction_deg = 3
force_N = 0.5
stiffness_N_mm = 1
seed = 3
[effect.read_noise]
rms = 1e-5
[effect.drift]
"""
CALIBRATION = """\
shear_gain = 1.0
normal_gain = 1.0
depth_mm = 1.5
[sigma]
shear_gain = 0.1
normal_gain = 0.1
depth_mm = 0.1
[radial]
located_um = [0.0, 100.0, 200.0]
true_um = [0.0, 110.0, 210.0]
force_factor = [1.0, 1.0, 1.0]
"""
TAXELS = """\
quantity = "strain"
rows = 1
cols = 2
[[taxel]]
at = [0, 0]
matrix = [[1, 0, 0], [0, 1, 0], [0, 0, 1]]
sigma = [[1, 0, 0], [0, 1, 0], [0, 0, 1]]
[[taxel]]
at = [0, 1]
matrix = [[1, 0, 0], [0, 1, 0], [0, 0, 1]]
"""
DETECTOR = """\
name = "two"
summary = "s"
reference = "r"
inputs = ["off"]
outputs = ["many", "off"]
llm = ["off", "many"]
[[event]]
kind = "many_on"
when = "many"
words = "w"
taxels = "off"
confirm_ms = 3
release_ms = 2
lag_ms = 1
[[event]]
kind = "some_on"
when = "many"
unless = "off"
direction = ["many", "many", "off", "off"]
sense = ["many", "off"]
[[step]]
copy = "off"
to = "many"
"""
TEMPLATE = """\
name = "mine"
summary = "s"
reference = "r"
A = [[0, 0, 0], [0, 2, 0], [0, 0, 0]]
B = 1
z = -0.5
input = "picture"
initial_state = "picture"
boundary = "zero-flux"
duration = 3
tags = ["x"]
margin = 0.1
note = "n"
aliases = ["o"]
cell = "chua-yang"
step = 0.1
frame_time = 2
[[term]]
weights = [[0, 0, 0], [0, 2, 0], [0, 0, 0]]
of = "u_kl - u_ij"
delay = 1
[[example]]
input = ["..", "#."]
state = ["..", "#."]
output = ["..", "#."]
tolerance = 0.1
"""
LAYERS = """\
name = "mine"
summary = "s"
reference = "r"
input = "picture"
initial_state = ["picture", 0]
boundary = "zero-flux"
duration = 3
[[layer]]
A = 2
B = 1
z = -0.5
time_constant = 1
[[layer]]
A = 2
z = -0.5
time_constant = 2
"""
PROGRAM = """\
name = "mine"
summary = "s"
reference = "r"
inputs = ["a"]
outputs = ["b"]
lam = ["a", "b", "k"]
[parameters]
w = 1.0
[keep]
k = 0.0
[templates.t]
A = [[0, 0, 0], [0, 2, 0], [0, 0, 0]]
B = 1
z = 0.5
boundary = "zero-flux"
duration = 3
[[step]]
template = "t"
input = "a"
state = "a"
to = "b"
"""


def _in_file(read: Callable[[Path], Any], name: str) -> Callable[[str], Any]:
    def from_text(text: str) -> Any:
        with TemporaryDirectory() as folder:
            path = Path(folder) / name
            path.write_text(text, encoding="utf-8")
            return read(path)

    return from_text


GOOD: dict[str, tuple[str, Callable[[str], Any]]] = {
    "description": (DESCRIPTION, lambda text: parse_description(text, "here")),
    "scene": (SCENE, lambda text: scene_from(parse_toml(text, "here"), "here")),
    "calibration": (CALIBRATION, lambda text: parse_calibration(text, "here")),
    "taxels": (TAXELS, lambda text: parse_calibration(text, "here")),
    "detector": (DETECTOR, _in_file(lambda path: read_detector(path, ("off", "touch")), "two.toml")),
    "template": (TEMPLATE, _in_file(load_file, "mine.toml")),
    "layers": (LAYERS, _in_file(load_file, "mine.toml")),
    "program": (PROGRAM, _in_file(load_program, "mine.toml")),
}
