"""Pictures of planes for notebooks."""

from io import BytesIO

import numpy as np
from PIL import Image

from cnnsim.support.pictures.picture import to_png


def test_a_coloured_line_stands_between_planes() -> None:
    """Five grids nine wide are not one of 45."""
    with Image.open(BytesIO(to_png(np.ones((5, 8, 9))))) as image:
        pixels = np.asarray(image.convert("RGB")).astype(int)
    coloured = np.ptp(pixels, axis=2).all(axis=0)
    assert np.count_nonzero(np.diff(coloured.astype(int)) == 1) == 4
    with Image.open(BytesIO(to_png(np.ones((8, 9))))) as image:
        assert np.asarray(image).ndim == 2
