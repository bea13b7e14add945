"""Fig. 11: displacement and strain below the bump, along x = 0."""

from pathlib import Path

import numpy as np

from cnnsim.support import Floats
from examples.paper.bump import CONTACT, CONTACTS, INDENTATION, SENSOR, below, loaded
from examples.paper.claims import Claim
from examples.paper.drawing import figure, plot_curves, save

DEPTHS = np.linspace(10e-6, 1.9e-3, 190)


def compare(folder: Path | None) -> list[Claim]:
    """Fig. 11: decrease of displacement and strain with the depth."""
    if folder is not None:
        draw(folder / "fig11.png")
    normal, shear = (moved[:, k] for moved, k in zip(loaded().displacement(below(DEPTHS)), (1, 0), strict=True))
    falls = falling(normal) and falling(shear)
    at = [float(np.interp(SENSOR, DEPTHS, part) * INDENTATION * 1e6) for part in (normal, shear)]
    turns = {solid: [turn(contact, solid) for contact in CONTACTS] for solid in (False, True)}
    squeezed = falling(-loaded().strain(below(DEPTHS))[0][:, 1])
    return [
        Claim("11", "both displacements decrease with the depth", "obvious",
              f"{at[0]:.1f} and {at[1]:.1f} um of 50 at 200 um, {trend(falls)}", falls),
        Claim("11", "normal strain decreases like normal displacement", "similar", trend(squeezed), squeezed),
        Claim("11", "shear strain decreases like shear displacement", "similar",
              f"changes sign {span(turns[False])} (contact {CONTACTS[0] * 1e6:.0f} to {CONTACTS[-1] * 1e6:.0f} um)",
              all(not np.isfinite(depth) for depth in turns[False]),
              f"straight below, a tangential force alone makes no shear strain; what is left are the contact's width "
              f"(one sign) and the tilting of the bump (the other). Body of revolution: {span(turns[True])}"),
    ]  # fmt: skip


def turn(contact: float, solid: bool) -> float:
    """Return the depth [m] of the first sign change of the shear strain on the axis under a shift, or NaN."""
    shear = loaded(contact, solid).strain(below(DEPTHS))[1][:, 0]
    change = np.flatnonzero(np.sign(shear[1:]) != np.sign(shear[:-1]))
    if not change.size:
        return float("nan")
    first = change[0]
    share = shear[first] / (shear[first] - shear[first + 1])
    return float(DEPTHS[first] + share * (DEPTHS[first + 1] - DEPTHS[first]))


def span(depths: list[float]) -> str:
    """Return the range of the depths [um], and the number of contacts without a change of sign."""
    known = [depth * 1e6 for depth in depths if np.isfinite(depth)]
    never = f", never for {len(depths) - len(known)} of {len(depths)} contacts" if len(known) < len(depths) else ""
    return f"{min(known):.0f} to {max(known):.0f} um deep{never}" if known else "never"


def falling(values: Floats) -> bool:
    """Return whether the values decrease strictly."""
    return bool((np.diff(values) < 0).all())


def trend(falls: bool) -> str:
    """Return the trend in words."""
    return "decreasing throughout" if falls else "not decreasing everywhere"


def draw(path: Path) -> None:
    """Write the figure."""
    from matplotlib import colormaps  # slow to import

    z, shades = DEPTHS * 1e6, colormaps["viridis"](np.linspace(0, 0.9, len(CONTACTS)))
    moved, normal, shear = [], [], []
    for solid, style, name in ((False, "-", "plane stress"), (True, "--", "body of revolution")):
        pressed, shifted = (part * INDENTATION for part in loaded(CONTACT, solid).displacement(below(DEPTHS)))
        moved.append((z, pressed[:, 1] * 1e6, style, "tab:blue", f"normal, {name}"))
        moved.append((z, shifted[:, 0] * 1e6, style, "tab:red", f"shear, {name}"))
        normal.append((z, loaded(CONTACT, solid).strain(below(DEPTHS))[0][:, 1] * INDENTATION, style, "tab:blue", name))
        for contact, shade in zip(CONTACTS, shades, strict=True):
            strain = loaded(contact, solid).strain(below(DEPTHS))[1][:, 0] * INDENTATION
            shear.append((z, strain, style, shade, None if solid else f"contact {contact * 1e6:.0f} µm"))
    drawn, (panels,) = figure(3, size=(4.7, 4.6))
    for panel in panels:
        panel.axvline(SENSOR * 1e6, color="0.6", linewidth=0.8)
        panel.axhline(0, color="k", linewidth=0.6)
        panel.set(xlim=(0, 1000), xlabel="depth on the axis [µm]; grey: the paper's sensor")
    plot_curves(panels[0], moved, title="displacement along the load [µm]", ylim=(0, 50))
    plot_curves(panels[1], normal, title="normal strain u_zz under the normal load")
    plot_curves(panels[2], shear, title="shear strain u_xz under the shear load", ylim=(-0.03, 0.008))
    save(drawn, path, "Below the bump, the plate moved by 50 µm (full: plane stress, dashed: body of revolution)")
