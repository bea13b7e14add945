"""Broken TOML files of every kind: wrong values in each key, cut short, nested deep, of many tables."""

import re
from collections.abc import Iterator

from tests.kits.paths import ROOT, SCENES

Broken = Iterator[tuple[str, bytes]]
"""File names, whose suffixes tell the reader, and contents."""

HUGE = ("1e9", "1000000000", "9223372036854775807", "1e308", "1e-300", "-1", "0", "nan", "inf", '"x"', "true", "[]",
        "{}", "[[]]", "1979-05-27", "9" * 400,
        '"' + "x" * 10000 + '"', '"\\u001b[2J"', '"../x"', "[1e308, 1e308]")  # fmt: skip

SCENE = (SCENES / "grip.toml").read_text(encoding="utf-8")
TEMPLATE = (ROOT / "templates" / "edge.toml").read_text(encoding="utf-8")
PROGRAM = (ROOT / "templates" / "programs" / "count-objects.toml").read_text(encoding="utf-8")
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
TRUTH = 'black = [["###", "###", "###"]]\nwhite = [["...", "...", "..."]]\ndefault = "black"\n'
TEXTS = {"scene.toml": SCENE, "template.toml": TEMPLATE, "program.toml": PROGRAM, "array.toml": ARRAY,
         "calibration.toml": CALIBRATION, "truth.toml": TRUTH}  # fmt: skip


def toml_files() -> Broken:
    """Every key of every kind of file with every wrong value, files cut short, nested deep, and of many tables."""
    for kind, text in TEXTS.items():
        lines = text.splitlines()
        for at, line in enumerate(lines):
            if found := re.match(r"([A-Za-z_]+)\s*=\s*", line):
                for value in HUGE:
                    yield kind, "\n".join([*lines[:at], f"{found[1]} = {value}", *lines[at + 1 :]]).encode()
                yield kind, "\n".join([*lines[:at], *lines[at + 1 :]]).encode()
        for cut in range(0, len(text), max(1, len(text) // 12)):
            yield kind, text[:cut].encode()
        for more in ('"' + "a." * 3000 + 'b"', "a." * 3000 + "b = 1", "x = " + "[" * 5000, "x = " + "{a=" * 3000,
                     "aliases = 1", "inputs = 3", 'keep = "x"', "\0", "title = '\x1b'"):  # fmt: skip
            yield kind, f"{more}\n{text}".encode()
        yield kind, text.encode("utf-16")
        yield kind, (text + "\n[[step]]" * (100_000 if kind in ("scene.toml", "template.toml") else 10_000)).encode()
        yield kind, b"#" + b"x" * 4_000_000
