"""The command that calibrates from a scan."""

from pathlib import Path

import click
import numpy as np

from cnnsim.support import InputError
from cnnsim.support.command_line import examples, print_json, watched
from cnnsim.support.echo import echo
from tactile.calibration.tare import Tare


@click.command(
    epilog=examples(
        "tactile calibrate scan.csv --speed-mm-s 0.5 --load-n 0.02 -o skin.toml",
        "tactile run grasp.csv --calibration skin.toml",
    )
)
@click.argument("scan", type=click.Path(path_type=Path))
@click.option("--speed-mm-s", type=float, required=True, help="True speed of the needle.")
@click.option("--load-n", type=float, required=True, help="True load of the needle.")
@click.option("--tare", type=int, default=0, show_default=True, help="Unloaded frames at the start to average away.")
@click.option(
    "--toward", type=(float, float), metavar="X Y",
    help="Direction of the slide in the array's frame; without it the sign of the shear is taken to be right.",
)  # fmt: skip
@click.option("-o", "--output", type=click.Path(path_type=Path), help="File for `tactile run --calibration`.")
@click.option("--json", "as_json", is_flag=True, help="Print JSON for a machine to read.")
def calibrate(
    scan: Path, speed_mm_s: float, load_n: float, tare: int, toward: tuple[float, float] | None, output: Path | None,
    as_json: bool,
) -> None:  # fmt: skip
    """Measure gains, depth and radial correction from SCAN.

    SCAN is a recording or a scene of one strain array, on which a needle is drawn straight over one taxel. The taxel
    that presses most is taken.
    """
    from tactile.calibration.file import write_calibration  # SciPy's splines are slow to import
    from tactile.calibration.from_scan import calibrate as from_scan  # the same
    from tactile.sources import open_source  # the same

    source = open_source(scan)
    (array, *others), modulus = source.arrays, source.modulus
    if others or array.quantity != "strain" or modulus is None:
        kinds = ", ".join(f"{one.name} ({one.quantity})" for one in source.arrays)
        raise InputError(f"{scan}: arrays {kinds}, modulus {modulus}: one strain array with a known modulus wanted")
    offset = Tare(tare)
    frames = [frame for frame in map(offset, watched(source, "scan", source.frames)) if frame.valid.any()]
    if not frames:
        raise InputError(f"{scan}: no frame with a valid taxel after {tare} frames of tare, some wanted")
    values = np.array([np.where(frame.valid[..., None], frame.values, 0.0) for frame in frames])
    row, col = np.unravel_index(np.abs(values[..., 2]).max(axis=0).argmax(), array.shape)
    use = np.array([frame.valid[row, col] for frame in frames])
    times = np.array([frame.t for frame in frames])
    made = from_scan(times[use], values[use, row, col], speed_mm_s * 1e-3, load_n, array.depth, modulus, toward)
    told = {
        "taxel": [int(row), int(col)],
        "beta_ns": made.gains.beta_ns,
        "shear_gain": made.gains.shear,
        "normal_gain": made.gains.normal,
        "depth_mm": made.depth * 1e3,
        "sigma": dict(zip(("shear_gain", "normal_gain", "depth_m"), made.sigma or (), strict=False)),
        "thicker": made.depth / array.depth,
        "radial_um": [
            [found * 1e6, true * 1e6] for found, true in zip(made.radial.found, made.radial.true, strict=True)
        ],
    }
    if as_json:
        print_json(told)
    else:
        echo(f"taxel ({row}, {col}), {int(use.sum())} frames")
        echo(f"beta_ns {made.gains.beta_ns:.4g}; gains {made.gains.shear:.6g},{made.gains.normal:.6g}")
        echo(f"depth {made.depth * 1e3:.4g} mm, {made.depth / array.depth:.3f} of the nominal one")
        stray = max(
            abs(true / found - 1) for found, true in zip(made.radial.found[1:], made.radial.true[1:], strict=True)
        )
        echo(f"radial correction to {made.radial.true[-1] * 1e6:.4g} um, at most {stray:.1%} of the distance")
    if output is not None:
        write_calibration(output, made)
        echo(f"wrote {output}", err=as_json)
