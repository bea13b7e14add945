"""Sweep of transients: a template on random pictures, grids of one shape as a batch."""

from collections.abc import Hashable, Sequence
from typing import Any

import numpy as np

from cnnsim.library.catalogue import load
from cnnsim.network import Template, parse_boundary
from cnnsim.network.boundary import BOUNDARY_FORMS
from cnnsim.support import Array, InputError
from cnnsim.support.toml_file import in_range
from cnnsim.sweep.kind import Case, Kind, Row
from cnnsim.transient import run_transient

KEYS = {
    "template": "a template of the library, or a file",
    "rows": "rows of the grid; 64 without it",
    "cols": "columns; as many as rows without it",
    "density": "the share of black cells of the random picture; 0.5 without it",
    "noise": "standard deviation of the noise added to the picture, which is then clipped to +-1",
    "seed": "of the random picture and its noise; 0 without it",
    "z": "the bias in place of the template's",
    "gain": "a factor on A and B",
    "boundary": f"{BOUNDARY_FORMS} in place of the template's",
    "time": "time constants in place of the template's rule",
    "step": "step in time constants",
    "scheme": "integration scheme",
    "limit": "the most time constants until settled",
    "dtype": "float32 or float64",
    "backend": "cpu, opencl or reference",
}
_OF_A_PLANE = ("density", "noise", "seed")
"""Keys that may differ between the grids of a batch."""


def group(case: Case) -> Hashable:
    """Return the values that the cases of a batch share: all except those that make the picture."""
    return repr(sorted((key, value) for key, value in case.items() if key not in _OF_A_PLANE))


def check(case: Case) -> None:
    """Check the template, the sizes and the numbers of a case, before any case is run."""
    if load(case["template"]).frame_time is not None:
        raise InputError(f"template {case['template']!r} takes moving pictures; one for single pictures wanted")
    for key in ("rows", "cols"):
        size = case.get(key, 64)
        if type(size) is not int or not 1 <= size <= 1 << 14:
            raise InputError(f"{key} = {size!r}; a whole number from 1 to {1 << 14} wanted")
    if type(case.get("seed", 0)) is not int or case.get("seed", 0) < 0:
        raise InputError(f"seed = {case['seed']!r}; a whole number from 0 on wanted")
    for key, low, high in (("density", 0.0, 1.0), ("noise", 0.0, np.inf)):
        number = case.get(key, low)
        if type(number) not in (int, float) or not (low <= number <= high and in_range(number)):
            raise InputError(f"{key} = {number!r}; a number from {low:g} to {high:g} wanted")


def picture(case: Case) -> Array:
    """Return the random picture of a case."""
    rows = case.get("rows", 64)
    random = np.random.default_rng(case.get("seed", 0))
    shown = np.where(random.random((rows, case.get("cols", rows))) < case.get("density", 0.5), 1.0, -1.0)
    if case.get("noise"):
        shown = np.clip(shown + case["noise"] * random.standard_normal(shown.shape), -1.0, 1.0)
    return shown


def run(cases: Sequence[Case]) -> list[Row]:
    """Run cases of one group as one batch; until settled, all run until the last one has settled."""
    first = cases[0]
    entry = load(first["template"])
    shown = np.array([picture(case) for case in cases])
    planes = entry.planes(shown, shown if "given" in _roles(entry.initial_state) else None)
    changes: dict[str, Any] = {key: first[key] for key in ("step", "scheme", "limit") if key in first}
    if "boundary" in first:
        changes["boundary"] = parse_boundary(first["boundary"])
    if "time" in first:
        changes["duration"] = first["time"]
    task = entry.changed({**planes, **entry.rules(shown.shape[-2:], 1, limit=first.get("limit"))}, changes)
    where = {"backend": first.get("backend", "cpu"), "dtype": first.get("dtype")}
    y = run_transient(_changed(entry.network, first), **task, **where).y
    return _row_of_each(y, shown)


def _row_of_each(y: Array, shown: Array) -> list[Row]:
    """Return the row of each grid; of all at once, as a call of NumPy takes as long as a small grid."""
    black, grids = y > 0, (-2, -1)
    found = {
        "black": black.sum(grids),
        "mean": y.mean(grids, dtype=np.float64),
        "changed": (black != (shown > 0)).sum(grids),
        "grey": (np.abs(y) < 1).sum(grids),
    }
    return [
        dict(zip(found, one, strict=True)) for one in zip(*(values.tolist() for values in found.values()), strict=True)
    ]


def _roles(initial_state: Any) -> tuple[Any, ...]:
    return initial_state if isinstance(initial_state, tuple) else (initial_state,)


def _changed(network: Any, case: Case) -> Any:
    """Return the template with the bias and the gain of a case."""
    if "z" not in case and "gain" not in case:
        return network
    if not isinstance(network, Template):
        raise InputError(f"template {case['template']!r} has layers; z and gain change a single one")
    gain = case.get("gain", 1.0)
    return Template(gain * network.A, gain * network.B, case.get("z", network.z), network.name, network.terms)


KIND = Kind(keys=KEYS, run=run, group=group, needed=("template",), check=check)
