"""Locking of finite elements: nearly incompressible rubber makes elements without pressures too stiff.

Stiffness of the bump under the plate relative to the finest mixed solution, for linear and quadratic displacements and
for quadratic displacements with linear pressures (Taylor and Hood), at three Poisson's ratios.
"""

import argparse
import sys
from collections.abc import Callable
from importlib.util import find_spec
from pathlib import Path

from cnnsim.support.extras import install_line

if find_spec("skfem") is None:
    sys.exit(f"finite elements wanted: {install_line('fem')}")

from tactile.bump.body import Body
from tactile.bump.kinematics import PRESSED
from tactile.bump.law import Displacement, Law, Mixed
from tactile.bump.mesh import half_section, plane_mesh
from tactile.bump.plate import plate_constraint, respond, stiffness
from tactile.bump.shape import Shape
from tactile.elastic.medium import Medium

KINDS: tuple[tuple[str, str, int, Callable[[Medium], Law]], ...] = (
    ("linear", "^-", 1, Displacement),
    ("quadratic", "s-", 2, Displacement),
    ("quadratic, linear pressure", "o-", 2, Mixed),
)
FINENESSES = (0.35, 0.5, 0.7, 1.0, 1.4)


def loaded(nu: float, fineness: float, degree: int, law: Callable[[Medium], Law]) -> tuple[int, float]:
    """(unknowns, stiffness over E [m]) of the bump on one mesh."""
    shape = Shape()
    mesh = plane_mesh(shape, fineness) if degree == 1 else half_section(shape, fineness)
    body = Body(mesh, PRESSED, law(Medium(1.0, nu)), degree)
    constraint = plate_constraint(body, shape, "press")
    return body.size, stiffness(body, constraint, respond(body, constraint))


def main(output: Path) -> None:
    """Write the picture to ``output``."""
    import matplotlib

    matplotlib.use("Agg")
    from matplotlib import pyplot as plt

    figure, panels = plt.subplots(1, 3, figsize=(12, 4.2), sharey=True, layout="constrained")
    for panel, nu in zip(panels, (0.3, 0.499, 0.4999), strict=True):
        _, true = loaded(nu, 2.5, 2, Mixed)
        for name, style, degree, law in KINDS:
            found = [loaded(nu, fineness, degree, law) for fineness in FINENESSES]
            panel.loglog([size for size, _ in found], [abs(stiff / true - 1) for _, stiff in found], style, label=name)
        panel.set_title(f"ν = {nu:g}")
        panel.set_xlabel("unknowns")
        panel.grid(alpha=0.3, which="both")
    panels[0].set_ylabel("relative error of the stiffness")
    panels[0].legend()
    figure.savefig(output, dpi=110)
    plt.close(figure)


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("-o", "--output", type=Path, default=Path("locking.png"), help="picture to write")
    main(parser.parse_args().output)
