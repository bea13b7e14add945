"""Calibration study: error before and after each calibration that the paper suggests but does not carry out.

``python -m examples.paper.calibration_gains [-o FOLDER] [--json]``. A sensor of beta_ns = 1.46 and 0.8 of its nominal
gain is calibrated in one scan and tried in another, along other lines. Steps, each on top of those before: beta_ns by
eq. (18) from the centre line; the linear thickness constant from the known speed; the absolute coefficients from the
known load; the radial correction measured point by point. The table has rms errors of places within 150 um and within
230 um, and of forces within 230 um.
"""

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from cnnsim.support import Flags
from examples.paper.claims import study
from examples.paper.drawing import figure, plot_curves, save
from examples.paper.needle import DEPTH, FORCE, NEAR, NOISE, SPEED, Located, Scan, locate, scan, typical
from examples.paper.skins import ALL, LINES, POINT, STRESS, Skin
from tactile.calibration.gains import Gains
from tactile.calibration.radial import radial_from_scan
from tactile.calibration.sensitivity import beta_from_scan
from tactile.inverse.validity import Validity

SENSOR = Gains(shear=1.46 / 0.8, normal=1 / 0.8)
FAR, RINGS, TRIED = 250e-6, 10, 230e-6
"""Radius [m] and number of rings of the radial correction, and radius [m] of the trial."""
STEPS = ("nominal", "beta_ns", "thickness", "load", "radial")
SKINS = (
    Skin("ideal", ()),
    Skin("noise", typical(*NOISE)),
    Skin("finite tip", typical("finite_tip")),
    Skin("finite thickness", typical("finite_thickness")),
    Skin("taxel area", typical("taxel_area")),
    Skin("strain nonlinearity", typical("strain_nonlinearity")),
    STRESS,
    POINT,
    ALL,
)


@dataclass(frozen=True)
class Gain:
    """Result of one step: rms errors of places [um] within 150 and 230 um and of forces [1] within 230 um.

    ``lost``: answers within 230 um that the radial correction refuses since they are located beyond its last ring;
    ``lost_inside``: those of them that truly lie within the second to last ring.
    """

    skin: str
    step: str
    near: float
    far: float
    force: float
    lost: int
    lost_inside: int


def error(step: str, skin: str, made: Scan, found: Located, answered: Flags, inside: float = TRIED) -> Gain:
    """Return the errors of a located scan."""
    off = np.hypot(*np.moveaxis(found.places - made.places, -1, 0)) * 1e6
    near, far = (made.within(radius) & answered for radius in (NEAR, TRIED))
    force = found.force[far] / FORCE - 1
    lost, lost_inside = (int((made.within(radius) & ~answered).sum()) for radius in (TRIED, inside))
    in_near, in_far, of_force = (float(np.sqrt((part**2).mean())) for part in (off[near], off[far], force))
    return Gain(skin, step, in_near, in_far, of_force, lost, lost_inside)


def calibrated(skin: Skin) -> list[Gain]:
    """Calibrate a skin step by step in one scan, and try every step in another."""
    centre = scan(effects=skin.effects, quantity=skin.quantity, gains=SENSOR, half=500e-6).readings[0]
    known = scan(LINES, skin.effects, quantity=skin.quantity, gains=SENSOR, seed=1)
    tried = scan(LINES[:-1] + 27e-6, skin.effects, quantity=skin.quantity, gains=SENSOR, seed=2)
    everywhere = np.ones(tried.times.shape, bool)
    near, far = known.within(NEAR), known.within(FAR)

    gains = Gains(1.0, 1.0)
    steps = [error("nominal", skin.name, tried, locate(tried, gains), everywhere)]
    gains = Gains(beta_from_scan(centre[:, 0], centre[:, 2]).beta, 1.0)
    steps.append(error("beta_ns", skin.name, tried, locate(tried, gains), everywhere))
    depth = DEPTH * SPEED / locate(known, gains).speed(known)
    steps.append(error("thickness", skin.name, tried, locate(tried, gains, depth), everywhere))
    factor = FORCE / float(locate(known, gains, depth).force[near].mean())
    gains = Gains(gains.shear * factor, gains.normal * factor)
    steps.append(error("load", skin.name, tried, locate(tried, gains, depth), everywhere))
    found = locate(known, gains, depth)
    radial = radial_from_scan(found.places[far], known.places[far], found.force[far], FORCE, RINGS)
    before = locate(tried, gains, depth)
    x, y = np.moveaxis(before.places, -1, 0)
    dx, dy, force, validity = radial((x, y, before.force, np.full(x.shape, float(Validity.INSIDE))))
    corrected = Located(np.stack([dx, dy], axis=-1), force)
    steps.append(error("radial", skin.name, tried, corrected, validity != Validity.INVALID, radial.true[-2]))
    return steps


def cells(gains: list[Gain]) -> list[str]:
    """Return the row of one skin in the table: its errors after every step."""
    shown = [f"{gain.near:.1f} | {gain.far:.1f} | {gain.force:.1%}" for gain in gains]
    lost = [f" ({gain.lost} lost)" if gain.lost else "" for gain in gains]
    return [gains[0].skin, *map(str.__add__, shown, lost)]


def draw(gains: list[Gain], path: Path) -> None:
    """Write the figure: errors of every skin after every step."""
    drawn, (panels,) = figure(3, size=(4.6, 4.4))
    what = (("near", "places within 150 µm [µm]"), ("far", "places within 230 µm [µm]"), ("force", "forces [1]"))
    names = dict.fromkeys(gain.skin for gain in gains if gain.skin != "ideal")
    for axes, (name, label) in zip(panels, what, strict=True):
        values = [[getattr(gain, name) for gain in gains if gain.skin == skin] for skin in names]
        curves = [(STEPS, one, "o-", f"C{n}", skin) for n, (one, skin) in enumerate(zip(values, names, strict=True))]
        plot_curves(axes, curves, yscale="log", ylabel=f"rms error of {label}")
    panels[0].axhspan(3, 5, color="0.9", zorder=0)
    panels[0].set_title("grey: the paper's 3-5 µm", fontsize=10)
    save(drawn, path, "Errors after each step; the ideal skin is exact after beta_ns and load")


def main() -> None:
    """Study all skins."""
    studies = [calibrated(skin) for skin in SKINS]
    gains = [gain for one in studies for gain in one]
    headings = ("skin", *(f"{step} [um | um | 1]" for step in STEPS))
    folder = study(__doc__.splitlines()[0], [vars(gain) for gain in gains], map(cells, studies), headings)
    if folder is not None:
        draw(gains, folder / "calibration_gains.png")


if __name__ == "__main__":
    main()
