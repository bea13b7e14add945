"""Expected outputs of the touch programs: hysteresis by hand, finite differences, votes by loops, queues.

x points right along the columns, y down along the rows. Planes are float arrays in CNN values.
"""

from __future__ import annotations

from collections import deque

import numpy as np
from scipy import ndimage

from tests.oracles.pictures import SQUARE, Picture, Plane
from tests.oracles.programs import Answer
from tests.oracles.sequences import Frames


def contact_blob(pressing: Plane, level: float = 0.25) -> Answer:
    """The edge: blob cells that see an 8-neighbour inside the array which is no blob."""
    contact = pressing > level
    blob = ndimage.binary_fill_holes(contact)
    edge = blob & ~ndimage.binary_erosion(blob, SQUARE, border_value=True)
    return {"contact": contact, "blob": blob, "edge": edge, "area": blob.sum(), "edge_length": edge.sum()}


def slip(frames: Frames, level: float = 0.25) -> list[Answer]:
    """Taxel by taxel: a direction goes on above 1/4 and off below 1/6 of full scale."""
    answers = []
    shape = frames[0]["shear_x"].shape
    code = np.zeros((*shape, 4), dtype=bool)
    touched_before, slid = np.zeros(shape, dtype=bool), np.zeros(shape, dtype=bool)
    for frame in frames:
        x, y = frame["shear_x"], frame["shear_y"]
        strength = np.stack((x, -x, y, -y), axis=-1)
        new = np.where(code, strength > 1 / 6, strength > 1 / 4)
        contact = frame["pressing"] > level
        slipped = (new != code).any(axis=-1) & contact & touched_before
        slid = (slid | slipped) & contact
        stuck = contact & ~slid
        front = np.zeros(shape, dtype=bool)
        for i, j in np.argwhere(slid):
            front[i, j] = stuck[max(i - 1, 0) : i + 2, max(j - 1, 0) : j + 2].any()
        planes = {"slipped": slipped, "slid": slid, "stuck": stuck, "front": front}
        answers.append({**planes, "slipping": int(slipped.any())})
        code, touched_before = new, contact
    return answers


def _slope(plane: Plane, axis: int) -> Plane:
    """numpy's gradient, its one-sided differences at the rim halved; 0 along a side of one taxel."""
    if plane.shape[axis] == 1:
        return np.zeros_like(plane)
    slope = np.gradient(plane, axis=axis)
    rim = np.moveaxis(slope, axis, 0)
    rim[[0, -1]] /= 2
    return np.asarray(slope)


def shear_flow(shear_x: Plane, shear_y: Plane, level: float = 0.1) -> Answer:
    divergence = _slope(shear_x, 1) + _slope(shear_y, 0)
    curl = _slope(shear_y, 1) - _slope(shear_x, 0)
    return {
        "divergence": divergence,
        "curl": curl,
        "spreading": divergence > level,
        "converging": divergence < -level,
        "clockwise": curl > level,
        "anticlockwise": curl < -level,
    }


def coherent_shear(
    shear_x: Plane, shear_y: Plane, pressing: Plane, level: float = 0.25, dead_band: float = 0.25, votes: int = 5
) -> Answer:
    contact = pressing > level
    answer: Answer = {"coherent": np.zeros_like(contact), "whole": 0}
    for name, strength in {"right": shear_x, "left": -shear_x, "down": shear_y, "up": -shear_y}.items():
        points = (strength > dead_band) & contact
        votes_for = ndimage.correlate(points.astype(int), np.ones((3, 3), dtype=int), mode="constant")
        answer[name] = (votes_for >= votes) & contact
        answer["coherent"] |= answer[name]
        answer["whole"] += int(2 * points.sum() > contact.sum())
    return answer


def onset_wave(contact: Picture, onset: Picture) -> Answer:
    """Geodesic reconstruction, and breadth-first search over eight neighbours for the order of arrival."""
    start = contact & onset
    arrival = np.where(start, 0, -1)
    queue = deque((int(i), int(j)) for i, j in np.argwhere(start))
    while queue:
        i, j = queue.popleft()
        for k in range(max(i - 1, 0), min(i + 2, contact.shape[0])):
            for l in range(max(j - 1, 0), min(j + 2, contact.shape[1])):
                if contact[k, l] and arrival[k, l] < 0:
                    arrival[k, l] = arrival[i, j] + 1
                    queue.append((k, l))
    return {"reached": ndimage.binary_propagation(start, SQUARE, contact), "arrival": arrival}
