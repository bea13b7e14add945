"""Explanation of a scene: every part with its size in the signal and its time per frame, and dropped effects."""

import json
from collections import Counter
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from tactile.simulator.auto_effects import Choice, choose
from tactile.simulator.contacts.height_map import HeightMap
from tactile.simulator.scene.scene import Scene
from tactile.simulator.scene_file.file import bare_scene, scene_table
from tactile.simulator.sizes import Sample, every_effect, sizes_in

WORDS = {
    "MovingLoad": "load",
    "MovingContact": "contact",
    "HeightMap": "height map",
    "SlidingTexture": "texture",
    "TractionMap": "map",
}
"""Names of the kinds of contact."""


@dataclass(frozen=True)
class ScenePart:
    """One part of a scene.

    ``size``: largest change of a reading, relative to the peak, when an effect alone is removed or, where it is off,
    added; ``at_most``: it is an upper bound: of random effects for all seeds but one in a million, of fixed ones before
    a converter for all positions of its steps. ``seconds``: measured time per frame, None for an effect that is off.
    """

    name: str
    what: str
    on: bool
    size: float
    seconds: float | None
    at_most: bool = False


@dataclass(frozen=True)
class SceneExplanation:
    """Explanation of a scene: ``lines`` about contacts and methods, ``parts`` in the order in which they act."""

    title: str
    peak: float
    unit: str
    lines: tuple[str, ...]
    parts: tuple[ScenePart, ...]
    notes: tuple[str, ...]


def explain_file(path: Path, write: Path | None = None) -> SceneExplanation:
    """Explain the scene in a file; with ``write`` also write a scene file with the chosen effects.

    Raises:
        InputError: as ``read_scene`` and ``write_choice``.
    """
    table = scene_table(path)
    scene, tolerance = bare_scene(table, str(path), path.parent)
    choice = choose(scene, tolerance, reused=write is not None) if tolerance is not None else None
    if write is not None:
        from tactile.simulator.scene_file.kept_choice import write_choice  # only where called for

        write_choice(path, table, choice, write)
    return explain(scene, choice)


def explain(scene: Scene, choice: Choice | None = None) -> SceneExplanation:
    """Explain a scene, or the scene of a ``choice`` of its effects."""
    effects = every_effect(scene)
    notes: list[str] = []
    if choice is not None:
        scene = choice.scene
        notes.append(
            f"effects chosen for a tolerance of {choice.tolerance:g} of the peak; error at most {choice.bound:.2g}"
        )
        if choice.left_out:
            dropped = ", ".join(f"{name} {size:.2g}" for name, size in choice.left_out.items())
            notes.append(f"left out, with the bound of their size: {dropped}")
    notes += scene.range_notes
    sample = Sample(scene)
    on = dict(scene.effects)
    seconds = sample.seconds(list(scene.effects))
    parts = [
        ScenePart(
            "contacts",
            f"{len(scene.loads) + len(scene.contacts)} on {len(scene.arrays)} finger{'s' * (len(scene.arrays) > 1)}",
            True,
            0.0,
            seconds["contacts"],
        ),
        ScenePart("field", _cover(scene), True, 1.0, seconds["field"]),
    ]
    if scene.bumps is not None:
        notes.append(
            f"against the flat cover the bumps change the signal by up to {_departure(scene, sample):.2g} of its peak"
        )
    sizes = sizes_in(scene, effects, sample)
    if absurd := [name for name, _ in effects if name not in sizes]:
        notes.append(f"not computable in this scene at typical strength, not measured: {', '.join(absurd)}")
    for name, effect in effects:
        if name not in sizes:
            continue
        size = sizes[name]
        parts.append(ScenePart(name, _describe(effect), name in on, size.change, seconds.get(name), size.at_most))
    quantity = scene.arrays[0].quantity
    return SceneExplanation(
        scene.title,
        sample.peak,
        {"stress": "Pa", "force": "N"}.get(quantity, quantity),
        tuple(_lines(scene)),
        tuple(parts),
        tuple(notes),
    )


def _cover(scene: Scene) -> str:
    if scene.bumps is not None:
        return str(scene.bumps)
    accuracy = f"to {scene.accuracy:g} of the peak" if scene.accuracy else "to rounding"
    return f"elastic half-space, incompressible; {accuracy}"


def _departure(scene: Scene, sample: Sample) -> float:
    """The largest difference from the field of the same loads on a half-space, relative to the peak."""
    flat = Sample(replace(scene, bumps=None)).fields
    gaps = [
        float(np.abs(one.values - other.values).max())
        for ours, theirs in zip(sample.fields, flat, strict=True)
        for one, other in zip(ours, theirs, strict=True)
    ]
    return max(gaps) / sample.peak


def _describe(effect: Any) -> str:
    """The effect as its table in a scene, without values of None."""
    values = {key: (getattr(effect, attribute), factor) for key, (attribute, factor) in effect.KEYS.items()}
    return ", ".join(
        f"{key} = {value / factor:g}" if isinstance(value, float) else f"{key} = {json.dumps(value)}"
        for key, (value, factor) in values.items()
        if value is not None
    )


def _lines(scene: Scene) -> list[str]:
    lines = []
    for finger, array in enumerate(scene.arrays):
        mine = [contact for contact in (*scene.loads, *scene.contacts) if contact.finger == finger]
        kinds = Counter(WORDS.get(type(contact).__name__, type(contact).__name__) for contact in mine)
        presses = ", ".join(f"{count} {kind}{'s' * (count > 1)}" for kind, count in kinds.items()) or "nothing presses"
        lines.append(
            f"{array.name}: {array.rows} x {array.cols} taxels of {array.quantity}, {array.depth * 1e3:g} mm deep; "
            f"{presses}"
        )
        maps = [contact for contact in mine if isinstance(contact, HeightMap)]
        if maps and scene.bumps is None:
            field = scene.fixed_field(scene.skin.field(finger, np.zeros(1)), finger)
            depth, bodies = field.taxels.depth, [one.on_dome(field.rig.curvature) for one in maps]
            lines += [f"height map on {array.name}: {one.described(field.medium, depth)}" for one in bodies]
    return lines
