"""Readers of files by name, called as a command calls them."""

import contextlib
import io
import tempfile
from importlib import import_module
from itertools import islice
from pathlib import Path
from typing import Any

from cnnsim.support import InputError

FRAMES = 1000
"""The most frames that are read of a recording."""
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
CALLS: dict[str, tuple[str, tuple[Any, ...]]] = {
    "template.toml": ("cnnsim.library.read:load_file", ()),
    "program.toml": ("cnnsim.program.file:load_program", ()),
    "array.toml": ("tactile.wire.description_file:read_description", ()),
    "calibration.toml": ("tactile.calibration.file:load_calibration", ()),
    "truth.toml": ("cnnsim.prototyping.design.rule_files:read_table", ()),
    "labels.csv": ("tactile.score.labels:read_labels", ()),
    "slide_labels.csv": ("tactile.materials.slide_labels:read_slide_labels", ()),
    "weights.csv": ("tactile.calibration.weights_file:read_weights", ()),
    "model.npz": ("tactile.materials.model_file:read_model", ()),
    "slides.npz": ("tactile.materials.slide_folder:read_slides", ()),
    "heights.npy": ("tactile.simulator.contacts.heights:read_heights", (1e-4,)),
    "body.stl": ("tactile.simulator.contacts.heights:read_heights", (1e-4,)),
}
"""Functions of a path and further arguments, as module:name."""


def read(path: Path, *, own_process: bool = False) -> None:
    """Read a file with the reader of its name, else of its suffix; ``own_process``: bags in a limited process.

    Raises:
        InputError: the file is refused.
    """
    name, suffix = path.name, path.suffix
    if name in CALLS:
        place, more = CALLS[name]
        module, function = place.split(":")
        getattr(import_module(module), function)(path, *more)
    elif name in ("zarr.json", "large.npy"):
        from cnnsim.supersteps.pictures import open_large

        open_large(path if suffix == ".npy" else path.parent)[:64, :64]
    elif name == "traction.npy":
        from tactile.simulator.scene_file.contact_tables import read_map

        read_map({"file": name, "pitch_mm": 1.0}, ["tip"], "map", path.parent)
    elif name == "sequences.npz":
        from tactile.score.sequences import read_sequences
        from tactile.wire.description_file import parse_description

        read_sequences(path, parse_description(BOARD, "board"))
    elif suffix in (".bag", ".db3", ".yaml"):
        _recording(path if suffix == ".bag" else path.parent) if own_process else _bag(path)
    elif suffix in (".m", ".gene", ".json", ".cnnsim", ".tem"):
        from cnnsim.formats.files import import_file

        with tempfile.TemporaryDirectory() as folder:
            import_file(path, Path(folder), replace=True)
    elif suffix in (".toml", ".csv", ".npz", ".parquet", ".mcap"):
        _recording(path)
    else:
        from cnnsim.support.pictures.read import read_pictures

        read_pictures(path)


def _recording(path: Path) -> None:
    """Read frames; those of a format with checksums have the values of `good_files`."""
    from tactile.sources import open_source

    for frame in islice(open_source(path), FRAMES):
        n = frame.sequence
        if path.name in ("r.mcap", "r.npz"):
            assert 0 <= n < 20 and abs(frame.t - 0.01 * n) < 1e-6 and (frame.values == n).all() and frame.valid.all()


def _bag(path: Path) -> None:
    """Read a bag as the process does that the product starts for it, but without its limits of memory."""
    from tactile.sources import bag_process

    with contextlib.redirect_stdout(io.TextIOWrapper(io.BytesIO())):
        try:
            with bag_process._opened(path if path.suffix == ".bag" else path.parent) as bag:
                bag_process._write_frames(bag)
        except Exception as error:  # as the process itself: the library raises anything
            raise InputError(f"{type(error).__name__}: {error}") from error
