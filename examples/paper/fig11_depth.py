"""Fig. 11: deformation below the bump, along x = 0; and the strain, which the paper says goes alike."""

from pathlib import Path

import numpy as np

from cnnsim.support import Floats
from examples.paper.bump import CONTACT, CONTACTS, INDENTATION, SENSOR, below, loaded
from examples.paper.claims import Claim, alone
from examples.paper.needle import figure

DEPTHS = np.linspace(10e-6, 1.9e-3, 190)


def compare(folder: Path | None) -> list[Claim]:
    """Fig. 11: what a thicker rubber costs, in displacement and in strain."""
    if folder is not None:
        draw(folder / "fig11.png")
    normal, shear = (moved[:, k] for moved, k in zip(loaded().displacement(below(DEPTHS)), (1, 0), strict=True))
    falls = falling(normal) and falling(shear)
    at = [float(np.interp(SENSOR, DEPTHS, part) * INDENTATION * 1e6) for part in (normal, shear)]
    turns = {solid: [turn(contact, solid) for contact in CONTACTS] for solid in (False, True)}
    squeezed = falling(-loaded().strain(below(DEPTHS))[0][:, 1])
    return [
        Claim("11", "the thicker the rubber, the less is left of both displacements", "obvious",
              f"{at[0]:.1f} and {at[1]:.1f} um of 50 at 200 um, {said(falls)}", falls),
        Claim("11", "normal strain goes like normal displacement", "similar", said(squeezed), squeezed),
        Claim("11", "shear strain goes like shear displacement", "similar",
              f"changes sign {span(turns[False])} (contact {CONTACTS[0] * 1e6:.0f} to {CONTACTS[-1] * 1e6:.0f} um)",
              all(not np.isfinite(depth) for depth in turns[False]),
              f"straight below, a tangential force alone makes no shear strain; what is left are the contact's width "
              f"(one sign) and the tilting of the bump (the other). Body of revolution: {span(turns[True])}"),
    ]  # fmt: skip


def turn(contact: float, solid: bool) -> float:
    """Depth [m] where the shear strain on the axis under a shift first changes sign, NaN where it does not."""
    shear = loaded(contact, solid).strain(below(DEPTHS))[1][:, 0]
    change = np.flatnonzero(np.sign(shear[1:]) != np.sign(shear[:-1]))
    if not change.size:
        return float("nan")
    first = change[0]
    share = shear[first] / (shear[first] - shear[first + 1])
    return float(DEPTHS[first] + share * (DEPTHS[first + 1] - DEPTHS[first]))


def span(depths: list[float]) -> str:
    """From where to where [um]; contacts under which nothing changes sign said aloud."""
    known = [depth * 1e6 for depth in depths if np.isfinite(depth)]
    never = f", never for {len(depths) - len(known)} of {len(depths)} contacts" if len(known) < len(depths) else ""
    return f"{min(known):.0f} to {max(known):.0f} um deep{never}" if known else "never"


def falling(values: Floats) -> bool:
    """Whether they get smaller from one to the next."""
    return bool((np.diff(values) < 0).all())


def said(falls: bool) -> str:
    """In words."""
    return "falling all the way" if falls else "not falling everywhere"


def draw(path: Path) -> None:
    """Write the picture."""
    from matplotlib import colormaps  # slow to import

    drawn, (panels,) = figure(3, size=(4.7, 4.6))
    for solid, style, name in ((False, "-", "plane stress"), (True, "--", "body of revolution")):
        answer = loaded(CONTACT, solid)
        pressed, shifted = answer.displacement(below(DEPTHS))
        panels[0].plot(
            DEPTHS * 1e6, pressed[:, 1] * INDENTATION * 1e6, style, color="tab:blue", label=f"normal, {name}"
        )
        panels[0].plot(DEPTHS * 1e6, shifted[:, 0] * INDENTATION * 1e6, style, color="tab:red", label=f"shear, {name}")
        squeezed = answer.strain(below(DEPTHS))[0]
        panels[1].plot(DEPTHS * 1e6, squeezed[:, 1] * INDENTATION, style, color="tab:blue", label=name)
        for contact, shade in zip(CONTACTS, colormaps["viridis"](np.linspace(0, 0.9, len(CONTACTS))), strict=True):
            sheared = loaded(contact, solid).strain(below(DEPTHS))[1]
            label = f"contact {contact * 1e6:.0f} µm" if not solid else None
            panels[2].plot(DEPTHS * 1e6, sheared[:, 0] * INDENTATION, style, color=shade, label=label)
    panels[0].set(title="displacement along the load [µm]", ylim=(0, 50))
    panels[1].set(title="normal strain u_zz under the normal load")
    panels[2].set(title="shear strain u_xz under the shear load", ylim=(-0.03, 0.008))
    for panel in panels:
        panel.axvline(SENSOR * 1e6, color="0.6", linewidth=0.8)
        panel.axhline(0, color="k", linewidth=0.6)
        panel.set(xlim=(0, 1000))
        panel.set_xlabel("depth on the axis [µm]; grey: the paper's sensor")
        panel.legend(fontsize=8)
    drawn.suptitle("Below the bump, the plate moved by 50 µm (full: plane stress, dashed: body of revolution)")
    drawn.savefig(path, dpi=110)


if __name__ == "__main__":
    alone(compare)
