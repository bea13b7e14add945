"""Functions for tests of running times: random planes, guaranteed times, and final outputs."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from cnnsim import library
from cnnsim.transient import run_transient
from tests.oracles.pictures import plane


def guaranteed(name: str, shape: tuple[int, int], **more: Any) -> float:
    entry = library.load(name)
    found = entry.running_time(shape, **more)
    assert found.time is not None, found
    return found.time


def pictures(name: str, shape: tuple[int, int]) -> list[dict[str, Any]]:
    """Planes of a sparse and a dense random picture for a template."""
    rng = np.random.default_rng([*name.encode(), *shape])
    entry, tasks = library.load(name), []
    for share in (0.3, 0.6):
        first = rng.random(shape) < share
        second = {
            "recall": first & (rng.random(shape) < 0.1),
            "connectivity": first & (rng.random(shape) < 0.9),
            "masked-shadow": ~first & (rng.random(shape) < 0.3),
        }.get(name, rng.random(shape) < 0.5)
        given = plane(second) if entry.initial_state == "given" else None
        planes = entry.planes(plane(first), given)
        if entry.initial_state == "any":
            planes["state"] = plane(second)
        tasks.append({**planes, "boundary": entry.boundary})
    return tasks


def final(name: str, task: dict[str, Any]) -> NDArray[Any]:
    return run_transient(library.load(name).template, **task, limit=20_000.0).y
