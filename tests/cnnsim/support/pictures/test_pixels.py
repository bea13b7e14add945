"""Every kind of picture file is read with its range, or refused with its numbers."""

import struct
import zlib
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from PIL import Image

from cnnsim import InputError, read_picture, read_pictures

GREY = np.array([[0, 51, 102], [153, 204, 255]], np.uint8)
WANTED = 1 - GREY / 127.5


def test_the_numbers_by_hand() -> None:
    assert WANTED[0, 0] == 1
    assert WANTED[1, 2] == -1
    assert WANTED[0, 1] == pytest.approx(0.6)


@pytest.mark.parametrize("mode", ["L", "P", "RGB", "RGBA", "LA", "CMYK", "YCbCr"])
def test_eight_bits_of_any_kind(tmp_path: Path, mode: str) -> None:
    name = tmp_path / ("x.tif" if mode in ("CMYK", "YCbCr") else "x.png")
    Image.fromarray(GREY).convert(mode).save(name)
    with Image.open(name) as image:
        assert image.mode == mode
    assert read_picture(name) == pytest.approx(WANTED, abs=0.01)
    assert np.array_equal(read_picture(name, binary=True), np.where(GREY < 128, 1.0, -1.0))


def test_one_bit(tmp_path: Path) -> None:
    Image.fromarray(GREY > 120).save(tmp_path / "x.png")
    assert np.array_equal(read_picture(tmp_path / "x.png"), np.where(GREY > 120, -1.0, 1.0))


@pytest.mark.parametrize("mode", ["LA", "RGBA", "P"])
def test_what_is_transparent_is_white(tmp_path: Path, mode: str) -> None:
    """Half transparent black over white is mid-grey."""
    image = Image.new("RGBA", (3, 1))
    for x, alpha in enumerate((0, 127, 255)):
        image.putpixel((x, 0), (0, 0, 0, alpha))
    if mode == "P":
        image = image.convert("RGB").quantize(4)
        image.info["transparency"] = image.getpixel((0, 0))
        image.save(tmp_path / "x.png", transparency=image.getpixel((0, 0)))
        assert np.all(read_picture(tmp_path / "x.png") == -1)
        return
    image.convert(mode).save(tmp_path / "x.png")
    assert read_picture(tmp_path / "x.png")[0] == pytest.approx([-1, 0, 1], abs=0.01)


@pytest.mark.parametrize("ending", ["png", "tif", "pgm"])
def test_sixteen_bits(tmp_path: Path, ending: str) -> None:
    numbers = np.array([[0, 100, 1000], [40000, 65000, 65535]], np.uint16)
    Image.fromarray(numbers).save(tmp_path / f"x.{ending}")
    assert read_picture(tmp_path / f"x.{ending}") == pytest.approx(1 - numbers / 32767.5, abs=1e-12)


def test_a_tiff_of_big_endian_sixteen_bits_and_one_where_white_is_zero(tmp_path: Path) -> None:
    numbers = np.array([[0, 65535], [300, 40000]], np.uint16)
    Image.frombytes("I;16B", (2, 2), numbers.astype(">u2").tobytes()).save(tmp_path / "big.tif")
    assert read_picture(tmp_path / "big.tif") == pytest.approx(1 - numbers / 32767.5, abs=1e-12)
    Image.fromarray(numbers).save(tmp_path / "turned.tif", tiffinfo={262: 0})
    assert read_picture(tmp_path / "turned.tif") == pytest.approx(numbers / 32767.5 - 1, abs=1e-12)


def test_sixteen_bits_with_a_colour_that_is_transparent(tmp_path: Path) -> None:
    Image.fromarray(np.array([[0, 1000]], np.uint16)).save(tmp_path / "x.png", transparency=1000)
    assert read_picture(tmp_path / "x.png")[0] == pytest.approx([1, -1])


def test_colours_of_sixteen_bits(tmp_path: Path) -> None:
    """A PNG of RGB with two bytes a colour, written by hand: Pillow writes none."""
    row = b"\0" + np.repeat(np.array([0, 0x8000, 0xFFFF], ">u2"), 3).tobytes()

    def chunk(kind: bytes, data: bytes) -> bytes:
        return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))

    header = struct.pack(">IIBBBBB", 3, 1, 16, 2, 0, 0, 0)
    parts = chunk(b"IHDR", header) + chunk(b"IDAT", zlib.compress(row)) + chunk(b"IEND", b"")
    (tmp_path / "x.png").write_bytes(b"\x89PNG\r\n\x1a\n" + parts)
    assert read_picture(tmp_path / "x.png")[0] == pytest.approx([1, 0, -1], abs=0.01)


@pytest.mark.parametrize(
    ("numbers", "wanted"),
    [([[0.0, 0.25, 1.0]], [[1.0, 0.5, -1.0]]), ([[-1.0, 0.25, 1.0]], [[-1.0, 0.25, 1.0]])],
)
def test_floats_in_a_known_range(tmp_path: Path, numbers: Any, wanted: Any) -> None:
    Image.fromarray(np.array(numbers, np.float32)).save(tmp_path / "x.tif")
    assert read_picture(tmp_path / "x.tif") == pytest.approx(np.array(wanted))


def test_numbers_without_a_range_are_refused_or_told(tmp_path: Path) -> None:
    Image.fromarray(np.array([[-0.5, 3.0]], np.float32)).save(tmp_path / "float.tif")
    Image.fromarray(np.array([[7, 70000]], np.int32)).save(tmp_path / "whole.tif")
    Image.fromarray(np.array([[0.0, np.nan]], np.float32)).save(tmp_path / "nan.tif")
    with pytest.raises(InputError, match=r"from -0.5 to 3 and does not say which are black and white"):
        read_picture(tmp_path / "float.tif")
    with pytest.raises(InputError, match=r"32 bits from 7 to 70000"):
        read_picture(tmp_path / "whole.tif")
    for levels in (None, (0, 1)):
        with pytest.raises(InputError, match=r"nan\.tif holds nan; finite numbers wanted"):
            read_picture(tmp_path / "nan.tif", levels=levels)
    assert read_picture(tmp_path / "float.tif", levels=(3, -0.5)).tolist() == [[-1, 1]]
    assert read_picture(tmp_path / "whole.tif", levels=(0, 140000))[0] == pytest.approx([1 - 1e-4, 0])
    with pytest.raises(InputError, match=r"from 7 to 70000; 0 \(black\) to 4095 wanted"):
        read_picture(tmp_path / "whole.tif", levels=(0, 4095))


@pytest.mark.parametrize(
    ("array", "wanted"),
    [
        (np.array([[True, False]]), [[[1, -1]]]),
        (np.array([[0, 255]], np.uint8), [[[1, -1]]]),
        (np.array([[[0, 65535]], [[65535, 0]]], np.uint16), [[[1, -1]], [[-1, 1]]]),
        (np.array([[0.0, 1.0]]), [[[0, 1]]]),  # CNN values already, unlike a float TIFF
        (np.array([[[[0, 0, 0], [255, 255, 255]]]], np.uint8), [[[1, -1]]]),
    ],
)
@pytest.mark.parametrize("ending", ["npy", "npz"])
def test_arrays(tmp_path: Path, array: np.ndarray, wanted: Any, ending: str) -> None:
    if ending == "npy":
        np.save(tmp_path / "x.npy", array)
    else:
        np.savez(tmp_path / "x.npz", frame=array)
    assert read_pictures(tmp_path / f"x.{ending}") == pytest.approx(np.array(wanted))


@pytest.mark.parametrize("dtype", ["?", "u1", "u2", "u4", "i1", "i2", "i8", "f4", "f8"])
@pytest.mark.parametrize("kind", ["zeros", "ones", "truth", "levels", "values", "beyond"])
def test_an_array_says_the_same_in_parts_as_whole(tmp_path: Path, dtype: str, kind: str) -> None:
    """Whole numbers as grey levels where they have 8 or 16 bits without a sign, else from -1 to 1, and not 0 alone."""
    pytest.importorskip("zarr")
    from cnnsim.supersteps.pictures import open_large

    array = {"zeros": [0, 0], "ones": [1, 1], "truth": [0, 1], "levels": [0, 90], "values": [-1, 1], "beyond": [-7, 90]}
    given = np.array([array[kind]]).astype(dtype)
    np.save(tmp_path / "x.npy", given)
    taken = dtype == "?" or dtype[0] == "f" or (dtype in ("u1", "u2") and kind != "truth")
    taken = taken and not (dtype[0] == "f" and kind in ("levels", "beyond"))
    taken |= (dtype[0] == "i" and kind in ("ones", "values")) or (dtype == "u4" and kind == "ones")
    for parts in (False, True):

        def read(path: Path, parts: bool = parts) -> Any:
            return open_large(path)[:, :] if parts else read_pictures(path)[0]

        if not taken:
            with pytest.raises(InputError, match=r"x\.npy.*--range"):
                read(tmp_path / "x.npy")
            continue
        if dtype == "?":
            wanted = np.where(given, 1.0, -1.0)
        else:
            wanted = 1 - given * (2 / np.iinfo(dtype).max) if dtype in ("u1", "u2") else given.astype(float)
        assert read(tmp_path / "x.npy") == pytest.approx(wanted, abs=1e-6)


def test_an_array_of_floats_is_told_of_as_one_of_cnn_values(tmp_path: Path) -> None:
    """Floats from 0 to 1 are grey levels in a TIFF, in an array they are not: its message must not say so."""
    np.save(tmp_path / "x.npy", np.array([[0.0, 3.5]]))
    with pytest.raises(InputError, match=r"from 0 to 3.5 .*; -1 \(white\) to 1 \(black\), or the range"):
        read_pictures(tmp_path / "x.npy")
    Image.fromarray(np.array([[0.0, 3.5]], np.float32)).save(tmp_path / "x.tif")
    with pytest.raises(InputError, match=r"from 0 to 3.5 .*; 0 to 1 \(grey\), -1 to 1 \(CNN values\), or the range"):
        read_picture(tmp_path / "x.tif")


def test_arrays_that_cannot_be_pictures(tmp_path: Path) -> None:
    np.savez(tmp_path / "two.npz", a=np.zeros((2, 2)), b=np.zeros((2, 2)))
    with pytest.raises(InputError, match="holds the arrays a, b; a single one wanted"):
        read_pictures(tmp_path / "two.npz")
    np.save(tmp_path / "x.npy", np.zeros((2, 2, 2, 2)))
    with pytest.raises(InputError, match=r"shape \(2, 2, 2, 2\); \(rows, cols\) or"):
        read_pictures(tmp_path / "x.npy")
    np.save(tmp_path / "x.npy", np.array([[3.5]]))
    with pytest.raises(InputError, match=r"from 3.5 to 3.5"):
        read_pictures(tmp_path / "x.npy")
    (tmp_path / "x.npy").write_bytes(b"no")
    with pytest.raises(InputError, match="cannot be read as an array"):
        read_pictures(tmp_path / "x.npy")
