"""Eight templates that are hard in different ways, with the planes and times on which accuracy is measured."""

from typing import Any

import numpy as np

from cnnsim import PERIODIC, LayeredTemplate, Template, Term, fixed

SIDE = 12


def families() -> dict[str, dict[str, Any]]:
    """Return what `make_task` takes for each: name -> template, planes, boundary, duration."""
    rng = np.random.default_rng(20)
    grey = rng.uniform(-1, 1, (SIDE, SIDE))
    black = np.where(rng.random((SIDE, SIDE)) < 0.5, 1.0, -1.0)
    cross = np.array([[0, 1, 0], [1, 0, 1], [0, 1, 0]])
    two = LayeredTemplate(
        [
            Template(0.1 * cross, z=0.1, terms=[Term([[-0.9]], "y_kl", layer=1)]),
            Template(0.05 * cross, terms=[Term([[0.9]], "y_kl", layer=0)]),
        ],
        [1.0, 2.0],
    )
    centre = np.diag([0.0, 1.0, 0.0])
    wave = Template(3 * centre + cross, 4 * centre, -1.0)
    heat = np.array([[0.1, 0.15, 0.1], [0.15, 0, 0.15], [0.1, 0.15, 0.1]])
    late = Template(0.5, z=0.1, terms=[Term(-0.25 * cross, "y_kl", delay=0.8)])
    found: dict[str, tuple[Any, Any, float, dict[str, Any]]] = {
        "uncoupled": (Template(2, -cross, 0.3), grey, 4.0, {"input": black, "boundary": fixed(-1)}),
        "propagating": (wave, np.ones_like(grey), 6.0, {"input": black, "boundary": fixed(-1)}),
        "diffusive": (Template(heat), grey, 5.0, {}),
        "oscillatory": (Template(np.outer([0, 1, 0], [-1.2, 2.0, 1.2])), grey, 8.0, {"boundary": fixed(0)}),
        "high gain": (Template(8 * centre + 0.5 * cross, z=0.2), grey * 0.1, 2.0, {}),
        "near-critical": (Template(0.25 * cross + 1e-7 * centre), grey, 10.0, {"boundary": PERIODIC}),
        "delayed": (late, grey, 8.0, {}),
        "layered": (two, np.stack([grey, grey[::-1]]), 8.0, {}),
    }
    return {
        name: {"template": template, "state": state, "duration": duration, **more}
        for name, (template, state, duration, more) in found.items()
    }
