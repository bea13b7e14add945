"""A calibrated skin: raw readings become strains by the gains of a calibration file, and loads newtons."""

from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np

from tactile import Settings, load_calibration, open_source, run

FILE = """shear_gain = 0.5\nnormal_gain = 0.5\ndepth_mm = 1.5
radial = { located_um = [0, 5000], true_um = [0, 5000], force_factor = [1, 1] }
"""


def main() -> None:
    """Read the grip's strains as if they were twice too large."""
    with TemporaryDirectory() as folder:
        path = Path(folder) / "skin.toml"
        path.write_text(FILE)
        skin = load_calibration(path)
    source = open_source(Path(__file__).parent / "scenes" / "grip.toml")
    result = run(source, Settings().calibrated(skin, source.arrays))
    firmest = max(float(np.nanmax(loads.F)) for loads in result.loads.values())
    assert abs(firmest - 0.75 / 2) < 1e-6
    print(f"the firmest press is {firmest:.3f} N")


if __name__ == "__main__":
    main()
