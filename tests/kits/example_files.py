"""The picture and the recording that lie beside the examples, as they are made: run as a module it writes them."""

from pathlib import Path

import numpy as np

from cnnsim import write_picture
from cnnsim.support import Floats
from tests.kits.paths import ROOT, SCENES

PICTURE, RECORDING = ROOT / "examples" / "scan.png", ROOT / "examples" / "grasp.npz"
SCENE = SCENES / "grip.toml"


def scan() -> Floats:
    """A grey scan of rings, bars and specks: black on white with a little noise, holes to fill and edges to find."""
    i, j = np.mgrid[:64, :96]
    picture = np.full(i.shape, -0.9)
    for row, col, inner, outer in ((18, 20, 6, 11), (44, 30, 4, 9), (30, 70, 10, 16)):
        distance = np.hypot(i - row, j - col)
        picture[(distance >= inner) & (distance <= outer)] = 0.9
    picture[54:58, 50:90] = picture[6:50, 90:93] = picture[29:32, 68:73] = 0.9
    noise = np.random.default_rng(2006).normal(0, 0.04, picture.shape)
    return np.clip(picture + noise, -1, 1)


def main() -> None:
    """Write both."""
    from tactile.sources.convert import convert

    write_picture(scan(), PICTURE)
    convert(SCENE, Path(RECORDING))


if __name__ == "__main__":
    main()
