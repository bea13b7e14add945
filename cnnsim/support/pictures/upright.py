"""Orientation of photographs: pictures turned as their EXIF data say, which is how every viewer shows them."""

from typing import Any

from PIL import Image

_ORIENTATION = 0x0112
"""Tag of EXIF and of TIFF."""
_ON_END = (5, 6, 7, 8)
"""Orientations that exchange rows and columns."""
_TURNS = {
    2: Image.Transpose.FLIP_LEFT_RIGHT, 3: Image.Transpose.ROTATE_180, 4: Image.Transpose.FLIP_TOP_BOTTOM,
    5: Image.Transpose.TRANSPOSE, 6: Image.Transpose.ROTATE_270, 7: Image.Transpose.TRANSVERSE,
    8: Image.Transpose.ROTATE_90,
}  # fmt: skip


def orientation(image: Image.Image) -> int:
    """Return how a picture lies, from 1 (upright) to 8, by its head alone: no pixels are read."""
    try:
        if image.format != "PNG":
            return _known(image.getexif().get(_ORIENTATION))
        exif = Image.Exif()  # Pillow's own question would decode a PNG, whose EXIF data may follow the pixels
        exif.load(image.info["exif"])
        return _known(exif.get(_ORIENTATION))
    except Exception:  # no EXIF data, or broken ones, of which Pillow raises anything: the pixels are good without
        return 1


def upright_size(image: Image.Image) -> tuple[int, int]:
    """Return (rows, cols) of a picture as it will be when it is `upright`."""
    cols, rows = image.size
    turned = image.format != "TIFF" and orientation(image) in _ON_END  # of a TIFF Pillow exchanges them itself
    return (cols, rows) if turned else (rows, cols)


def upright(image: Image.Image) -> Image.Image:
    """Return a picture turned upright; one that lies so is returned as it is. Pillow turns a TIFF when it reads it."""
    turn = None if image.format == "TIFF" else _TURNS.get(orientation(image))
    return image if turn is None else image.transpose(turn)


def read_through(image: Image.Image) -> None:
    """Keep Pillow from mapping a TIFF on its end into memory: it takes rows for columns there."""
    if image.format == "TIFF" and orientation(image) in _ON_END:
        vars(image)["filename"] = ""  # of files alone, so that Pillow's types do not know it


def _known(found: Any) -> int:
    return found if found in _TURNS else 1
