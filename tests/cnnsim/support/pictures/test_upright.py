"""Pictures lie as their EXIF data say; labels are no grey levels; too large ones are refused."""

import zlib
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from PIL import Image

from cnnsim import InputError, read_picture
from cnnsim.supersteps.pictures import open_large
from cnnsim.support.pictures.read import read_pictures

PLANE = np.random.default_rng(3).random((5, 8)) < 0.5
GREY = np.where(PLANE, 0, 255).astype(np.uint8)
UPRIGHT = {
    1: PLANE, 2: PLANE[:, ::-1], 3: PLANE[::-1, ::-1], 4: PLANE[::-1], 5: PLANE.T, 6: PLANE[::-1].T,
    7: PLANE[::-1, ::-1].T, 8: PLANE.T[::-1],
}  # fmt: skip
"""What a picture is whose pixels lie as EXIF's orientation says: row and column 0 of the file are 6: right, top; ..."""


@pytest.mark.parametrize("lying", UPRIGHT)
@pytest.mark.parametrize(("name", "mode", "options"), [
    ("a.png", "L", {}), ("a.png", "I;16", {}), ("a.png", "P", {}), ("a.png", "LA", {}), ("a.tif", "L", {}),
    ("a.tif", "L", {"compression": "tiff_lzw"}), ("a.tif", "F", {}), ("a.webp", "RGB", {"lossless": True}),
    ("a.jpg", "L", {"quality": 100}),
])  # fmt: skip
def test_a_picture_lies_as_it_is_seen(
    lying: int, name: str, mode: str, options: dict[str, Any], tmp_path: Path
) -> None:
    exif, path = Image.Exif(), tmp_path / name
    exif[0x0112] = lying
    image = Image.fromarray(GREY)
    if mode == "I;16":
        image = Image.fromarray(GREY.astype(np.uint16) * 257)
    elif mode == "F":
        image = Image.fromarray(np.where(PLANE, 1, -1).astype(np.float32))
    image = image if mode in ("L", "I;16", "F") else image.convert(mode)
    image.save(path, exif=exif, **options)
    assert np.array_equal(read_picture(path) > 0, UPRIGHT[lying])
    assert np.array_equal(read_pictures(path, path)[1] > 0, UPRIGHT[lying])
    whole = open_large(path)
    assert whole.shape == UPRIGHT[lying].shape and np.array_equal(whole[:, :] > 0, UPRIGHT[lying])


def test_broken_exif_data_spoil_no_picture(tmp_path: Path) -> None:
    Image.fromarray(GREY).save(tmp_path / "a.png", exif=b"Exif\x00\x00MM\x00*\xff\xff")
    assert np.array_equal(read_picture(tmp_path / "a.png") > 0, PLANE)


@pytest.mark.parametrize("name", ["a.png", "a.npy", "int.npy"])
def test_zeros_and_ones_are_labels_and_no_grey_levels(name: str, tmp_path: Path) -> None:
    path = tmp_path / name
    if name == "a.png":
        Image.fromarray(PLANE.astype(np.uint8)).save(path)
    else:
        np.save(path, PLANE.astype(np.int64 if name == "int.npy" else np.uint8))
    for read in (read_picture, read_pictures) if name == "a.png" else (read_pictures,):
        with pytest.raises(InputError, match=r"holds the numbers 0 and 1 alone.*--range 1,0"):
            read(path)
    assert np.array_equal(read_pictures(path, levels=(1, 0))[0] > 0, PLANE)
    assert np.array_equal(read_pictures(path, levels=(0, 1))[0] > 0, ~PLANE)
    assert (read_pictures(path, levels=(0, 255)) > 0.9).all()


@pytest.mark.parametrize("levels", [(1e308, -1e308), (0, 1e-320), (0.0, 0.0), (0, float("nan"))])
def test_a_range_that_floats_cannot_divide_by_is_refused(levels: tuple[float, float], tmp_path: Path) -> None:
    Image.fromarray(GREY).save(tmp_path / "a.png")
    with pytest.raises(InputError, match="two different numbers, of some size, wanted"):
        read_picture(tmp_path / "a.png", levels=levels)


def test_a_picture_that_does_not_fit_into_memory_is_refused_before_its_pixels_are_read(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("CNNSIM_MEMORY", "1G")
    path = tmp_path / "a.png"
    Image.fromarray(GREY).save(path)
    data = bytearray(path.read_bytes())
    data[16:24] = (30000).to_bytes(4, "big") * 2
    data[29:33] = zlib.crc32(data[12:29]).to_bytes(4, "big")
    path.write_bytes(data)
    with pytest.raises(InputError, match=r"reading 30000 x 30000 pixels needs 9.9 GB of memory, 1 GB are free"):
        read_picture(path)
