"""Sweep of scenes: a scene file with changed arrays, effects, forces, seeds and thresholds."""

from collections import Counter
from collections.abc import Sequence
from functools import cache
from pathlib import Path
from time import perf_counter
from typing import Any

import numpy as np

from cnnsim.support import InputError
from cnnsim.sweep.kind import Case, Kind, Row
from tactile.output.collected import Collected
from tactile.output.ground_truth import truth_of
from tactile.pipeline import run as run_pipeline
from tactile.settings import PipelineOptions
from tactile.simulator.scene_file.file import scene_from, scene_table

FINGER = ("rows", "cols", "pitch_mm", "depth_mm")
TOP = ("rate_hz", "duration_s", "seed")
THRESHOLDS = ("dead_band", "hysteresis", "contact_level")
KEYS = {
    "scene": "a scene file",
    "rows": "rows of taxels of each finger",
    "cols": "columns of taxels",
    "pitch_mm": "distance of the taxels [mm]",
    "depth_mm": "depth of the taxels [mm]",
    "rate_hz": "frames a second",
    "duration_s": "length of the scene [s]",
    "seed": "of the effects' random numbers",
    "youngs_modulus_mpa": "of the cover [MPa]",
    "effects": "false for no effects, or a table of [effect.NAME] tables instead of the file's",
    "force": "a factor on all forces of the scene's loads",
    "dead_band": "least threshold of shear, as --dead-band",
    "hysteresis": "as --hysteresis",
    "contact_level": "least threshold of contact, as --contact-level",
    "sigmas": "three multiples of the noise, as --sigmas",
    "program": "a detector or program file",
}


def changed_table(case: Case) -> tuple[dict[str, Any], Path]:
    """Return a scene's table with the changes of a case, and its folder."""
    path = Path(case["scene"])
    table = dict(_table(path))
    table |= {key: case[key] for key in TOP if key in case}
    fingers = {key: case[key] for key in FINGER if key in case}
    table["finger"] = [{**finger, **fingers} for finger in table.get("finger", [])]
    if "youngs_modulus_mpa" in case:
        table["cover"] = {**table.get("cover", {}), "youngs_modulus_mpa": case["youngs_modulus_mpa"]}
    if "effects" in case:
        wanted = case["effects"]
        if wanted is not False and not isinstance(wanted, dict):
            raise InputError(f"effects = {wanted!r}; false, or a table of effects, wanted")
        for key in ("effect", "effects", "tolerance"):
            table.pop(key, None)
        if wanted:
            table["effect"] = wanted
    if "force" in case and table.get("load"):
        scale = np.array([1, 1, 1, *[case["force"]] * 3])
        table["load"] = [{**load, "path": (np.array(load["path"]) * scale).tolist()} for load in table["load"]]
    return table, path.parent


@cache
def _table(path: Path) -> dict[str, Any]:
    return scene_table(path)


def check(case: Case) -> None:
    """Check that a case is a scene."""
    table, folder = changed_table(case)
    scene_from(table, case["scene"], folder)
    if "force" in case and not table.get("load"):
        raise InputError(f"{case['scene']}: no [[load]] with forces, which 'force' multiplies; one wanted")


def run(cases: Sequence[Case]) -> list[Row]:
    """Run cases one after another: frames of one scene need those before them."""
    return [run_one(case) for case in cases]


def run_one(case: Case) -> Row:
    """Run the pipeline over a scene, and return counts of events by kind, and errors of the located loads."""
    table, folder = changed_table(case)
    scene = scene_from(table, case["scene"], folder)
    chosen: dict[str, Any] = {key: case[key] for key in (*THRESHOLDS, "sigmas") if key in case}
    if "program" in case:
        chosen["program"] = (case["program"],)
    settings = PipelineOptions(**chosen).settings(scene)
    seen = Collected(truth_of(scene))
    begun = perf_counter()
    run_pipeline(scene, settings, [seen])
    seconds = perf_counter() - begun
    errors = np.concatenate([seen.errors(array.name) for array in scene.arrays])
    known = errors[np.isfinite(errors[:, 0])]
    row: Row = {"frames": seen.frames, "frame_rate": seen.frames / seconds, "events": len(seen.events),
                "located": len(known)}  # fmt: skip
    if len(known):
        row["place_error_mm"] = float(1e3 * np.sqrt((known[:, 0] ** 2).mean()))
        row["force_error_N"] = float(np.sqrt(np.nanmean(known[:, 1] ** 2)))
    first = min((event.t for event in seen.events), default=None)
    return row | {"first_event_s": first} | dict(Counter(f"events_{event.kind}" for event in seen.events))


KIND = Kind(keys=KEYS, run=run, needed=("scene",), check=check, paths=("scene", "program"))
