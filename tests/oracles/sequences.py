"""Expected outputs of programs that keep planes: for the frames of a sequence, the outputs of each run."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy as np
from scipy import ndimage

from tests.oracles.pictures import SQUARE, Picture
from tests.oracles.programs import Answer, touched

Frames = Sequence[Mapping[str, Any]]


def _with_before(frames: Frames) -> list[tuple[Picture, Picture]]:
    pictures = [frame["frame"] for frame in frames]
    return list(zip([np.zeros_like(pictures[0]), *pictures], pictures, strict=False))


def motion(frames: Frames) -> list[Answer]:
    answers = []
    for before, now in _with_before(frames):
        moving = touched(now, now & ~before)
        planes = {"appeared": now & ~before, "vanished": before & ~now, "moving": moving, "resting": now & ~moving}
        answers.append({**planes, "motion": int((now != before).any())})
    return answers


def speed(frames: Frames, cells: int = 1) -> list[Answer]:
    """Chessboard distance to the nearest black cell of the frame before, object by object."""
    answers = []
    for before, now in _with_before(frames):
        far = np.full(now.shape, np.inf)
        if before.any():
            far = ndimage.distance_transform_cdt(~before, "chessboard")
        slow = np.zeros_like(now)
        labels, number = ndimage.label(now, SQUARE)
        for label in range(1, number + 1):
            slow |= (labels == label) & (far[labels == label].max() <= cells)
        answers.append({"slow": slow, "fast": now & ~slow})
    return answers


def direction(frames: Frames) -> list[Answer]:
    """An object fits a direction if all its cells, one step back, were black before."""
    back = {"east": (0, -1), "west": (0, 1), "north": (1, 0), "south": (-1, 0), "rest": (0, 0)}
    answers = []
    for before, now in _with_before(frames):
        answer = {name: np.zeros_like(now) for name in back}
        labels, number = ndimage.label(now, SQUARE)
        wide = np.pad(before, 1)
        for label in range(1, number + 1):
            cells = np.argwhere(labels == label)
            for name, step in back.items():
                if all(wide[i + 1 + step[0], j + 1 + step[1]] for i, j in cells):
                    answer[name] |= labels == label
        answers.append(answer)
    return answers


SEQUENCES: dict[str, Callable[..., Any]] = {
    "motion-detection": motion,
    "motion-speed": speed,
    "motion-direction": direction,
}
