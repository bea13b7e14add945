"""Where a strain sensor under a bump should sit, if the width of the contact is unknown.

The paper argues with displacements, and its sensors measure strain. Straight below a tangential force there is no shear
strain: what a sensor on the axis reads comes from the contact's width and from the tilting of the bump, which have
opposite signs. All for the body of revolution, nu = 0.499, strain per newton of force on the bump.
"""

import argparse
import sys
from functools import cache
from importlib.util import find_spec
from pathlib import Path

import numpy as np

from cnnsim.support import Floats
from cnnsim.support.extras import install_line

if find_spec("skfem") is None:
    sys.exit(f"finite elements wanted: {install_line('fem')}")

from tactile.bump.body import Body
from tactile.bump.kinematics import PRESSED, SHEARED
from tactile.bump.law import Mixed
from tactile.bump.mesh import half_section
from tactile.bump.plate import plate_constraint, respond, stiffness
from tactile.bump.probe import Probe
from tactile.bump.shape import Shape
from tactile.elastic.medium import Medium

RUBBER = Medium(0.87e6, 0.499)
CONTACTS = np.array([30e-6, 50e-6, 70e-6, 100e-6, 120e-6, 140e-6])
DEPTHS = np.concatenate([np.linspace(-80e-6, 0, 5), np.linspace(20e-6, 500e-6, 25)])
SENSOR = 200e-6
ASIDE = np.linspace(10e-6, 400e-6, 40)
"""Half the distance [m] of two sensors to both sides of the axis."""


@cache
def strains(contact: float) -> tuple[Floats, Floats, Floats, Floats]:
    """Per newton: zz and xz on the axis at the depths; zz under press and under shift, aside at the sensors' depth."""
    shape = Shape(contact=contact)
    mesh = half_section(shape, 1.5)
    points = np.concatenate(
        [
            np.stack([np.zeros_like(DEPTHS), DEPTHS], axis=-1),
            np.stack([ASIDE, np.full_like(ASIDE, SENSOR)], axis=-1),
        ]
    )
    read = []
    for kinematics in (PRESSED, SHEARED):
        body = Body(mesh, kinematics, Mixed(RUBBER))
        constraint = plate_constraint(body, shape, "press" if kinematics is PRESSED else "shift")
        state = respond(body, constraint)
        read.append(Probe(body, points).strain(state) / stiffness(body, constraint, state))
    count = len(DEPTHS)
    return read[0][:count, 2, 2], read[1][:count, 0, 2], read[0][count:, 2, 2], read[1][count:, 2, 2]


def spread(values: Floats) -> Floats:
    """Largest over smallest along the contacts (the first axis), infinite where the sign changes."""
    low, high = np.abs(values).min(axis=0), np.abs(values).max(axis=0)
    same = (np.sign(values) == np.sign(values[0])).all(axis=0)
    return np.where(same, high / np.maximum(low, 1e-300), np.inf)


def study() -> dict[str, float]:
    """The figures of the conclusion."""
    squeezed, sheared, _, tilted = (np.array(part) for part in zip(*(strains(c) for c in CONTACTS), strict=True))
    on_axis = spread(sheared)
    safe = DEPTHS[: int(np.argmax(np.isinf(on_axis)))]  # down to where the first contact turns the sign
    beside = spread(tilted)
    best = int(np.argmax(np.abs(tilted).min(axis=0)))
    at = {z: int(np.argmin(np.abs(DEPTHS - z * 1e-6))) for z in (20, 40, 200)}
    return {
        "deepest without a change of sign [um]": float(safe.max() * 1e6),
        "spread of shear on the axis, 20 um": float(on_axis[at[20]]),
        "spread of shear on the axis, 40 um": float(on_axis[at[40]]),
        "spread of shear on the axis, 200 um": float(on_axis[at[200]]),
        "normal over shear on the axis, 20 um, least": float((squeezed / sheared)[:, at[20]].min()),
        "normal over shear on the axis, 20 um, most": float((squeezed / sheared)[:, at[20]].max()),
        "best half distance of a pair [um]": float(ASIDE[best] * 1e6),
        "spread of the pair's difference": float(beside[best]),
        "pair's half difference [1/N]": float(np.abs(tilted[:, best]).min()),
        "largest shear on the axis at 200 um [1/N]": float(np.abs(sheared[:, at[200]]).max()),
    }


CONCLUSION = """\
On the axis a shear sensor must sit shallow: down to {0:.0f} um under the body's surface its sign does not depend on the
contact's width, and at 20 um its gain varies by a factor of {1:.1f}. At the paper's 200 um the sign itself is open.
Where 200 um of rubber are needed, two normal sensors {2:.0f} um to both sides of the axis do better: half their
difference is the shear force, of one sign and within a factor of {3:.1f} for all contacts and as large as what the
normal force makes; half their sum is the normal force, the same for all contacts; neither depends on the other load."""


def main(output: Path) -> None:
    """Print the conclusion and write the picture to ``output``."""
    import matplotlib

    matplotlib.use("Agg")
    from matplotlib import pyplot as plt

    found = study()
    for name, value in found.items():
        print(f"{name:45} {value:.4g}")
    keys = ("deepest without a change of sign [um]", "spread of shear on the axis, 20 um")
    more = ("best half distance of a pair [um]", "spread of the pair's difference")
    print(CONCLUSION.format(*(found[key] for key in keys + more)))
    figure, panels = plt.subplots(1, 3, figsize=(14, 4.8), layout="constrained")
    shades = plt.get_cmap("viridis")(np.linspace(0, 0.85, len(CONTACTS)))
    for contact, shade in zip(CONTACTS, shades, strict=True):
        squeezed, sheared, pressed, tilted = strains(contact)
        label = f"{contact * 1e6:.0f} µm"
        panels[0].plot(DEPTHS * 1e6, sheared, color=shade, label=label)
        panels[1].plot(DEPTHS * 1e6, sheared / squeezed, color=shade)
        panels[2].plot(ASIDE * 1e6, -tilted, color=shade)
        panels[2].plot(ASIDE * 1e6, -pressed, "--", color=shade)
    panels[0].set(title="on the axis: shear strain per newton of shear", ylim=(-12, 3), ylabel="[1/N]")
    panels[0].legend(title="half-width of the contact", fontsize=8)
    panels[1].set(title="on the axis: shear strain over normal strain", ylim=(-1, 3))
    panels[2].set(title="two normal sensors, 200 µm deep", ylabel="[1/N]")
    panels[2].plot([], [], "k-", label="half the difference, shear load")
    panels[2].plot([], [], "k--", label="half the sum, normal load")
    panels[2].legend(fontsize=8)
    for panel in panels[:2]:
        panel.axvline(SENSOR * 1e6, color="0.6", linewidth=0.8)
        panel.axhline(0, color="k", linewidth=0.6)
        panel.set_xlabel("depth under the body's surface [µm]; below 0 in the bump")
    panels[2].set_xlabel("half the distance of the pair [µm]")
    figure.savefig(output, dpi=110)
    plt.close(figure)


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("-o", "--output", type=Path, default=Path("strain_sensor.png"), help="picture to write")
    main(parser.parse_args().output)
