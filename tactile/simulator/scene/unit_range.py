"""Numbers of a scene that a wrong unit explains: warnings with the number found and the expected range."""

from collections.abc import Iterator
from typing import Any

import numpy as np

from tactile.core.loads import X, Y
from tactile.simulator.scene.extremes import checked_field
from tactile.thresholds.threshold import CONTACT

SOFTEST, HARDEST = 1e3, 1e10
"""Young's moduli [Pa] between a soft gel and a hard polymer."""
OUTSIDE = 3.0
"""Distance of a load from the outermost taxels [depths], beyond which they read 1 % of its peak."""
LATEST = 300.0
"""End of a path over the scene's duration: scenes are cut short on purpose, to try them, by smaller factors."""
HIGHEST = 1e3
"""Range of a height map over its pitch."""


# Contacts are distinguished by their attributes: a kind that a scene does not name is not imported.
def doubtful_units(scene: Any) -> Iterator[str]:  # a `Scene`, which imports this
    """Yield one line for each number of a scene that is far from any skin or is lost in its recording."""
    if not SOFTEST <= scene.modulus <= HARDEST:
        yield (
            f"modulus {scene.modulus:g} Pa; {SOFTEST:g} (a soft gel) to {HARDEST:g} Pa (a hard polymer) wanted: "
            "it is in pascals"
        )
    for contact in (*scene.loads, *scene.contacts):
        yield from _path(scene, contact)
        if hasattr(contact, "heights") and np.ptp(contact.heights) > HIGHEST * contact.pitch:
            yield (
                f"height map: heights over {np.ptp(contact.heights) * 1e3:.3g} mm on cells of "
                f"{contact.pitch * 1e3:.3g} mm; at most {HIGHEST:g} times the pitch wanted: heights are in metres"
            )
        if hasattr(contact, "material") and contact.material.period > 0:
            yield from _tone(scene, contact)
    shaken = any(effect.RANDOM and effect.STAGE == "field" for _, effect in scene.effects)
    for finger in range(0 if shaken else len(scene.arrays)):  # a shaken contact may press harder than it shows here
        mine = [one for one in (*scene.loads, *scene.contacts) if one.finger == finger]
        cut = any(hasattr(one, "path") and one.path[-1, 0] > scene.duration for one in mine)  # may press harder later
        if mine and not cut:
            yield from _signal(scene, finger)


def _path(scene: Any, contact: Any) -> Iterator[str]:
    """Lines for a path that lies off the pad, lasts less than a frame, or ends long after the scene."""
    if not hasattr(contact, "path"):
        return
    path = contact.path
    name, begin, end = type(contact).__name__, float(path[0, 0]), float(path[-1, 0])
    if len(path) > 1 and end - begin < 1 / scene.rate:
        yield f"{name}: a path of {end - begin:.3g} s; at least a frame of {1 / scene.rate:.3g} s wanted"
    if len(path) > 1 and end > LATEST * scene.duration:
        yield (
            f"{name}: a path until {end:.3g} s in a scene of {scene.duration:.3g} s, at most {LATEST:g} times its "
            "duration wanted: times are in seconds"
        )
    if path.shape[1] < 3:  # a traction map stays in its place
        return
    array = scene.arrays[contact.finger]
    at = array.positions().reshape(-1, 2)
    places = path[:, 1:][:, [X, Y]]
    ahead = np.linspace(places[:-1], places[1:], 16).reshape(-1, 2) if len(path) > 1 else places
    off = np.maximum(np.maximum(at.min(axis=0) - ahead, ahead - at.max(axis=0)), 0)
    nearest = float(np.hypot(off[:, 0], off[:, 1]).min())
    depth = array.depth or array.pitch  # force taxels may lie at the surface
    if nearest > OUTSIDE * depth:
        yield (
            f"{name}: {nearest * 1e3:.3g} mm or more from the taxels of {array.name!r}; at most {OUTSIDE:g} depths of "
            f"{depth * 1e3:.3g} mm wanted: places are in metres"
        )


def _tone(scene: Any, texture: Any) -> Iterator[str]:
    """Line for a texture whose period passes faster than every second frame."""
    tone = texture.speed / texture.material.period
    if tone > scene.rate / 2:
        alias = abs(tone - scene.rate * round(tone / scene.rate))
        yield (
            f"{texture.material.name} at {texture.speed * 1e3:.3g} mm/s: a tone of {tone:.3g} Hz at {scene.rate:.3g} "
            f"frames/s shows as {alias:.2g} Hz; at most half the frame rate, {scene.rate / 2:.3g} Hz, wanted"
        )


def _signal(scene: Any, finger: int) -> Iterator[str]:
    """Lines for the largest reading of a few frames below the dead band, the noise, or a count of the converter."""
    array, unit, effects = scene.arrays[finger], scene.unit(finger), dict(scene.effects)
    largest = float(np.abs(checked_field(scene, finger).values).max(initial=0))
    of, said = (
        {"strain": "of strain", "stress": "Pa", "force": "N"}[array.quantity],
        f"{array.name}: readings up to {largest:.3g}",
    )
    full, least = scene.full_scale * unit, CONTACT[array.quantity].dead_band
    if 0 < largest <= least:
        yield f"{said} {of}; above the dead band of {least:g} wanted, below which nothing is a contact"
    noise, converter = effects.get("read_noise"), effects.get("quantisation")
    if noise is not None and 0 < largest < noise.rms * full:
        yield f"{said} {of}; above the noise of {noise.rms * full:.3g} wanted (read_noise.rms is a part of full scale)"
    step = 2 * converter.span * full / 2**converter.bits if converter is not None and converter.bits else 0.0
    if 0 < largest < step:
        yield f"{said} {of}; above one count of {step:.3g} wanted (quantisation.span is a part of full scale)"
