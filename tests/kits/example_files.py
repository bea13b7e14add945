"""The picture and the recording of the examples; run as a module to write them."""

from pathlib import Path

import numpy as np

from cnnsim import write_picture
from cnnsim.support import Floats
from tests.kits.paths import ROOT, SCENES

PICTURE, RECORDING = ROOT / "examples" / "scan.png", ROOT / "examples" / "grasp.npz"
SCENE = SCENES / "grip.toml"


def scan() -> Floats:
    """Return a grey scan of rings, bars and specks, black on white, with noise."""
    i, j = np.mgrid[:64, :96]
    picture = np.full(i.shape, -0.9)
    for row, col, inner, outer in ((18, 20, 6, 11), (44, 30, 4, 9), (30, 70, 10, 16)):
        distance = np.hypot(i - row, j - col)
        picture[(distance >= inner) & (distance <= outer)] = 0.9
    picture[54:58, 50:90] = picture[6:50, 90:93] = picture[29:32, 68:73] = 0.9
    noise = np.random.default_rng(2006).normal(0, 0.04, picture.shape)
    return np.clip(picture + noise, -1, 1)


def main() -> None:
    """Write the picture and the recording."""
    from tactile.sources.convert import convert

    write_picture(scan(), PICTURE)
    convert(SCENE, Path(RECORDING))


if __name__ == "__main__":
    main()
