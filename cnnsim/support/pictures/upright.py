"""Orientation of photographs: pictures are turned upright by their EXIF data, as viewers show them."""

from typing import Any

from PIL import Image, ImageOps

_ORIENTATION = 0x0112
"""Tag of EXIF and of TIFF."""


def orientation(image: Image.Image) -> int:
    """Return the EXIF orientation of a picture, from 1 (upright) to 8, without decoding its pixels."""
    try:
        if image.format == "PNG":  # whose EXIF data may follow the pixels: `getexif` would decode them
            exif = Image.Exif()
            exif.load(image.info["exif"])
        else:
            exif = image.getexif()
        found: Any = exif.get(_ORIENTATION)
    except Exception:  # no EXIF data, or broken ones, for which Pillow raises any error
        return 1
    return found if found in range(1, 9) else 1


def upright_size(image: Image.Image) -> tuple[int, int]:
    """Return (rows, cols) of a picture after `upright`."""
    cols, rows = image.size
    turned = image.format != "TIFF" and orientation(image) >= 5  # Pillow turns a TIFF, and its size, by itself
    return (cols, rows) if turned else (rows, cols)


def upright(image: Image.Image) -> Image.Image:
    """Return a picture turned upright; Pillow turns a TIFF when it reads it."""
    turned = image.format != "TIFF" and orientation(image) > 1
    return ImageOps.exif_transpose(image) if turned else image


def read_through(image: Image.Image) -> None:
    """Prevent Pillow from mapping a TIFF of orientation 5 to 8 into memory: it exchanges rows and columns there."""
    if image.format == "TIFF" and orientation(image) >= 5:
        vars(image)["filename"] = ""  # an attribute of image files only, which Pillow's types lack
