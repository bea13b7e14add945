"""Command `calibrate`: calibration from a scan or from known weights."""

from pathlib import Path
from typing import get_args

import click
import numpy as np

from cnnsim.support import InputError
from cnnsim.support.command_files import claim
from cnnsim.support.command_line import examples, print_json, replace_option, watched
from cnnsim.support.terminal import echo
from tactile.calibration.from_weights import NAMES, Model, calibrate_loads
from tactile.calibration.live_tare import LiveTare
from tactile.cli.options import FILE, JSON
from tactile.core.frame import Frame
from tactile.core.source import Source
from tactile.sources import open_source


@click.command(
    epilog=examples(
        "tactile calibrate scan.csv --speed-mm-s 0.5 --load-n 0.02 -o skin.toml",
        "tactile run grasp.csv --calibration skin.toml",
        "tactile calibrate pad.npz --tare 100 --weights weights.csv -o pad.toml",
        "tactile calibrate pad.npz --tare 100 --weights weights.csv --fit gains --json",
    )
)
@click.argument("scan", type=FILE)
@click.option("--speed-mm-s", type=float, help="True speed of the needle.")
@click.option("--load-n", type=float, help="True load of the needle.")
@click.option(
    "--weights", type=FILE,
    help="CSV table of known loads: from_s, to_s, grams (or f_n), and optionally q_n, r_n, x_mm, y_mm.",
)  # fmt: skip
@click.option(
    "--fit", type=click.Choice(get_args(Model)), default="matrix", show_default=True,
    help="With --weights: a 3 x 3 matrix of every taxel, three gains of every taxel, or one matrix for all.",
)  # fmt: skip
@click.option("--tare", type=int, default=0, show_default=True, help="Unloaded frames at the start, for the offset.")
@click.option(
    "--toward", type=(float, float), metavar="X Y",
    help="Direction of the slide in the array's frame; without it the sign of the shear is assumed to be right.",
)  # fmt: skip
@click.option("-o", "--output", type=FILE, help="File for `tactile run --calibration`.")
@replace_option
@JSON
def calibrate(
    scan: Path, speed_mm_s: float | None, load_n: float | None, weights: Path | None, fit: Model, tare: int,
    toward: tuple[float, float] | None, output: Path | None, as_json: bool,
) -> None:  # fmt: skip
    """Measure gains, depth and radial correction.

    From SCAN, or the gains of every taxel from known weights.

    SCAN is a recording or a scene of one array. With --speed-mm-s and --load-n a needle is drawn straight over one
    taxel of strain; the taxel with the largest normal reading is used. With --weights known loads lie on it one after
    the other: anywhere on a pad that measures force, at known places on one of strain or stress.
    """
    claim(output)
    if weights is not None:
        if speed_mm_s is not None or load_n is not None or toward is not None:
            raise click.UsageError("--weights gives the loads; leave out --speed-mm-s, --load-n and --toward")
        _from_weights(scan, weights, fit, tare, output, as_json)
        return
    if speed_mm_s is None or load_n is None:
        raise click.UsageError("--speed-mm-s and --load-n of a needle wanted, or --weights FILE")
    from tactile.calibration.file import write_calibration  # slow to import
    from tactile.calibration.from_scan import calibrate as from_scan  # the same

    source = open_source(scan)
    (array, *others), modulus = source.arrays, source.modulus
    if others or array.quantity != "strain" or modulus is None:
        kinds = ", ".join(f"{one.name} ({one.quantity})" for one in source.arrays)
        raise InputError(f"{scan}: arrays {kinds}, modulus {modulus}: one strain array with a known modulus wanted")
    frames = _tared(source, scan, tare)
    values = np.array([np.where(frame.valid[..., None], frame.values, 0.0) for frame in frames])
    row, col = np.unravel_index(np.abs(values[..., 2]).max(axis=0).argmax(), array.shape)
    use = np.array([frame.valid[row, col] for frame in frames])
    times = np.array([frame.t for frame in frames])
    made = from_scan(times[use], values[use, row, col], speed_mm_s * 1e-3, load_n, array.depth, modulus, toward)
    result = {
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
        print_json(result)
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


def _tared(source: Source, scan: Path, tare: int) -> list[Frame]:
    offset = LiveTare(0, source.arrays[0], tare)
    frames = [frame for frame in map(offset, watched(source, "scan", source.frames)) if frame.valid.any()]
    if not frames:
        raise InputError(f"{scan}: no frame with a valid taxel after {tare} frames of tare, some wanted")
    return frames


def _from_weights(scan: Path, weights: Path, fit: Model, tare: int, output: Path | None, as_json: bool) -> None:
    """Calibrate every taxel by known loads."""
    from tactile.calibration.taxel_file import write_taxel_gains  # imported when used
    from tactile.calibration.weights_file import read_weights, steady_means  # the same

    times, loads = read_weights(weights)
    source = open_source(scan)
    if len(source.arrays) != 1:
        names = ", ".join(array.name for array in source.arrays)
        raise InputError(f"{scan}: arrays {names}; a recording of one array wanted")
    (array,) = source.arrays
    frames = _tared(source, scan, tare)
    t = np.array([frame.t for frame in frames])
    values = np.array([np.where(frame.valid[..., None], frame.values, np.nan) for frame in frames])
    made = calibrate_loads(steady_means(t, values, times, str(scan)), loads, array, source.modulus, fit)
    gain, error = (np.diagonal(part, axis1=2, axis2=3) for part in (made.matrix, made.sigma))
    cross = made.matrix * (1 - np.eye(3)) / gain[..., None]
    if as_json:
        result = {"quantity": array.quantity, "loads": len(times), "fit": fit, "cross_axis": float(np.abs(cross).max())}
        print_json(result | {"matrix": made.matrix.tolist(), "sigma": made.sigma.tolist()})
    else:
        echo(f"{len(times)} loads, {array.rows} x {array.cols} taxels of {array.quantity}")
        for name, one, off in zip(NAMES, np.moveaxis(gain, -1, 0), np.moveaxis(error, -1, 0), strict=True):
            echo(f"{name} gains {one.min():.6g} to {one.max():.6g}, known to {np.abs(off / one).max():.2%}")
        echo(f"cross-axis: at most {np.abs(cross).max():.2%} of a gain")
    if output is not None:
        write_taxel_gains(output, made)
        echo(f"wrote {output}", err=as_json)
