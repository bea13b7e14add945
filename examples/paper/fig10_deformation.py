"""Fig. 10: deformation of the bump's section under a normal and a tangential load of 50 um."""

from pathlib import Path

import numpy as np

from examples.paper.bump import CONTACTS, INDENTATION, SENSOR, below, loaded
from examples.paper.claims import Claim
from examples.paper.drawing import figure, save

OFF = 25e-6
"""[m] Distance of a misplaced sensor from the axis."""


def compare(folder: Path | None) -> list[Claim]:
    """Fig. 10: zero cross-talk at x = 0, superposition of small deformations."""
    if folder is not None:
        draw(folder / "fig10.png")
    depths = below(np.linspace(0, 1.9e-3, 39))
    cross, off = 0.0, []
    for contact in CONTACTS:
        pressed, shifted = loaded(contact).displacement(depths)
        cross = max(cross, np.abs(pressed[:, 0] / pressed[:, 1]).max(), np.abs(shifted[:, 1] / shifted[:, 0]).max())
        pressed, shifted = loaded(contact).displacement(below(SENSOR, OFF))
        off.append(max(abs(pressed[0, 0] / pressed[0, 1]), abs(shifted[0, 1] / shifted[0, 0])))
    typical = rms_strain() * INDENTATION
    return [
        Claim("10", "displacement across the load, along x = 0", "none", f"{cross:.0e} of that along it",
              bool(cross < 1e-9), f"by symmetry; {OFF * 1e6:.0f} um off the axis {min(off):.0%} to {max(off):.0%}"),
        Claim("10", "deformations are small, loads superpose (50 um)", "assumed", f"strain {typical:.2f} in the bump",
              bool(typical < 0.1), "root mean square of the largest principal strain; effect: see Fig. 12"),
    ]  # fmt: skip


def rms_strain() -> float:
    """Return the root mean square of the largest principal strain in the hemisphere, per metre of indentation."""
    body, state = loaded().bodies[0], loaded().states[0]
    gradient, _ = body.at_points(state)
    strain = (gradient + np.swapaxes(gradient, -1, -2)) / 2 - np.eye(3)
    largest = np.abs(np.linalg.eigvalsh(strain[..., ::2, ::2])).max(axis=-1)
    weight = body.weight * (np.asarray(body.basis.global_coordinates())[1] < 0)
    return float(np.sqrt((largest**2 * weight).sum() / weight.sum()))


def draw(path: Path) -> None:
    """Write the figure."""
    answer = loaded()
    body, mesh = answer.bodies[0], answer.bodies[0].mesh
    count = mesh.nvertices
    drawn, panels = figure(2, 2, (5.5, 3.7))
    for row, state, load in zip(panels, answer.states, "zx", strict=True):
        moved = state[body.basis.nodal_dofs[:, :count]] * INDENTATION
        at = (mesh.p[:, :count] + moved) * 1e6
        for panel, component, name in ((row[0], 1, "z"), (row[1], 0, "x")):
            value = moved[component] * 1e6
            limit = np.abs(value).max()
            colours = panel.tripcolor(*at, mesh.t.T, value, cmap="RdBu_r", vmin=-limit, vmax=limit, shading="gouraud")
            panel.triplot(*at, mesh.t.T, color="0.2", linewidth=0.15)
            panel.axvline(0, color="k", linewidth=0.6, linestyle=":")
            panel.set(title=f"load {load}, deformation {name}", aspect="equal", xlim=(-700, 700), ylim=(700, -260))
            panel.set(xlabel="x [µm]", ylabel="z [µm]")
            drawn.colorbar(colours, ax=panel, label="deformation [µm]", shrink=0.65)
    save(drawn, path, "The bump's section in plane stress, the plate moved by 50 µm")
