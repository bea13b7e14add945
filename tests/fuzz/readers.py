"""Every reader of a file, by the name or the suffix of what it reads, as a user's command would call it."""

import contextlib
import io
import os
import tempfile
from collections.abc import Callable
from itertools import islice
from pathlib import Path

from cnnsim.support import InputError

FRAMES = 1000
"""Frames that are read of a recording: a scene of a year is no broken file."""
SUMMED = (".mcap", ".npz")
"""Recordings with sums over all bytes: what is read of a changed one is what was written."""


def read_source(path: Path) -> None:
    from tactile.sources import open_source

    for frame in islice(open_source(path), FRAMES):
        n = frame.sequence
        if path.name in {f"r{suffix}" for suffix in SUMMED} and not (
            0 <= n < 20 and abs(frame.t - 0.01 * n) < 1e-6 and (frame.values == n).all() and frame.valid.all()
        ):
            raise AssertionError(f"a frame that was not written: {frame}")


def _template(path: Path) -> None:
    from cnnsim.library.read import load_file

    load_file(path)


def _program(path: Path) -> None:
    from cnnsim.program.file import load_program

    load_program(path)


def _array(path: Path) -> None:
    from tactile.wire.description_file import read_description

    read_description(path)


def _calibration(path: Path) -> None:
    from tactile.calibration.file import load_calibration

    load_calibration(path)


def _truth(path: Path) -> None:
    from cnnsim.prototyping.design.rule_files import read_table

    read_table(path)


def _foreign(path: Path) -> None:
    from cnnsim.formats.files import import_file

    with tempfile.TemporaryDirectory() as folder:
        import_file(path, Path(folder), replace=True)


def _picture(path: Path) -> None:
    from cnnsim.support.pictures.read import read_pictures

    read_pictures(path)


def _large(path: Path) -> None:
    from cnnsim.supersteps.pictures import open_large

    plane = open_large(path if path.suffix == ".npy" else path.parent)
    plane[: min(plane.shape[0], 64), : min(plane.shape[1], 64)]


def _labels(path: Path) -> None:
    from tactile.score.labels import read_labels

    read_labels(path)


def _slide_labels(path: Path) -> None:
    from tactile.materials.slide_labels import read_slide_labels

    read_slide_labels(path)


def _weights(path: Path) -> None:
    from tactile.calibration.weights_file import read_weights

    read_weights(path)


def _model(path: Path) -> None:
    from tactile.materials.model_file import read_model

    read_model(path)


def _slides(path: Path) -> None:
    from tactile.materials.slide_folder import read_slides

    read_slides(path)


def _sequences(path: Path) -> None:
    from tactile.score.sequences import read_sequences
    from tactile.wire.description_file import parse_description

    read_sequences(path, parse_description(BOARD, "board"))


def _heights(path: Path) -> None:
    from tactile.simulator.contacts.heights import read_heights

    read_heights(path, 1e-4)


def _traction(path: Path) -> None:
    from tactile.simulator.scene_file.contact_tables import read_map

    read_map({"file": path.name, "pitch_mm": 1.0}, ["tip"], "map", path.parent)


def _bag(path: Path) -> None:
    """Read a bag within the limits of the process that the product starts, without its start."""
    from tactile.sources import bag_process

    said = io.StringIO()
    try:
        with contextlib.redirect_stderr(said), Path(os.devnull).open("w") as none, contextlib.redirect_stdout(none):
            bag_process.main(path if path.suffix == ".bag" else path.parent)
    except SystemExit as end:
        if end.code != 2 or not said.getvalue().strip():
            raise AssertionError(f"ended with {end.code}: {said.getvalue()}") from end
        raise InputError(said.getvalue()) from end


BOARD = """
title = "board"
protocol = "reskin"
[[finger]]
name = "tip"
rows = 1
cols = 2
pitch_mm = 7.0
depth_mm = 2.0
quantity = "field"
"""
BY_NAME: dict[str, Callable[[Path], None]] = {
    "template.toml": _template, "program.toml": _program, "array.toml": _array, "calibration.toml": _calibration,
    "truth.toml": _truth, "large.npy": _large, "zarr.json": _large, "labels.csv": _labels,
    "slide_labels.csv": _slide_labels, "weights.csv": _weights, "model.npz": _model, "slides.npz": _slides,
    "sequences.npz": _sequences, "heights.npy": _heights, "body.stl": _heights, "traction.npy": _traction,
}  # fmt: skip
BY_SUFFIX: dict[str, tuple[Callable[[Path], None], ...]] = {
    ".toml": (read_source,), ".csv": (read_source,), ".npz": (read_source, _picture), ".npy": (_picture,),
    ".parquet": (read_source,), ".mcap": (read_source,), ".bag": (_bag,), ".db3": (_bag,), ".yaml": (_bag,),
    ".m": (_foreign,), ".gene": (_foreign,), ".json": (_foreign,), ".cnnsim": (_foreign,), ".tem": (_foreign,),
    ".png": (_picture,), ".gif": (_picture,), ".bmp": (_picture,), ".tif": (_picture,), ".jpg": (_picture,),
    ".pgm": (_picture,), ".mp4": (_picture,),
}  # fmt: skip
