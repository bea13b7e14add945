"""Stillness of a block of frames: whether the array moves or is touched meanwhile, or wanders by noise of its own."""

from dataclasses import dataclass

import numpy as np

from cnnsim.support import Floats
from tactile.core.frame import NORMAL
from tactile.core.noise import Noise, spread

PARTS = 4
"""Still: the means of so many parts of a block agree."""
MUCH = 4.0
"""Half of the taxels may wander on their own; one that is pressed meanwhile by up to so many times as much."""
WANDER = 7.0
"""Times the jitter of a taxel, or its noise within a part, that its mean may wander in a block and still be called
still; 8 is what a load comes to that grows evenly all the time, slow noise alone mostly to 3 to 6."""
NEWEST = 5
"""Frames that are asked whether a load begins; as many before them count for neither side."""
BEGINS = 8.0
"""Sigma by which a taxel must be pressed where a load begins."""


@dataclass(frozen=True)
class Stillness:
    """What a block is: ``still`` or not; ``far``: how far means move, 1 where it is too far; its ``first`` part's mean.

    ``within`` (rows, cols, 3): noise within the parts, which neither slow noise nor a load that grows is part of.
    """

    still: bool
    far: float
    first: Floats
    within: Floats


def judge(block: Floats, noise: Noise, limit: Floats, inward: float | Floats) -> Stillness:
    """Return whether frames (n, rows, cols, 3) are still.

    Args:
        block: Frames; NaN where a taxel did not read.
        noise: Noise that was measured of them.
        limit: Dead bands (3,) or (rows, cols, 3) [unit of the frames], of which means may move by half.
        inward: Sign of a pressing load, one or (rows, cols).
    """
    split = np.array_split(block, PARTS)
    parts = np.array([np.nanmean(part, axis=0) for part in split])
    within = np.median([spread(part) for part in split], axis=0)
    least = np.maximum(limit / 2, WANDER * np.maximum(noise.jitter, within))
    # one without readings is still; taxels with slow noise of their own are not an array that moves
    far = (parts.max(axis=0) - parts.min(axis=0)) / least
    pressed = (inward * (parts - parts[0])[..., NORMAL]).max(axis=0) > least[..., NORMAL]
    touched = bool((pressed & (far > MUCH).any(-1)).any())
    wanders = 2 * (far > 1).any(-1).sum() > max(far.shape[0] * far.shape[1], 2)
    # together taxels tell a load that each hides in its noise; what is alike on most is drift, or told above
    press = inward * block[..., NORMAL]
    alone = press - np.nanmedian(press, axis=(1, 2), keepdims=True)
    whole = [np.nansum(part, axis=(1, 2)) for part in np.array_split(alone, PARTS)]
    means = np.array([one.mean() for one in whole])
    bound = float(np.median(limit[..., NORMAL])) / 2 * alone[0].size ** 0.5
    grows = float((means.max() - means[0]) / max(bound, WANDER * float(np.median([spread(one) for one in whole]))))
    return Stillness(not (touched or wanders or grows > 1), max(float(far.max()), grows), parts[0], within)


def begins(frames: list[Floats], limit: Floats, inward: float | Floats) -> bool:
    """Return whether a taxel is pressed in the newest frames by more than those well before them explain."""
    before = np.array(frames[: -2 * NEWEST])[..., NORMAL]
    press = inward * (np.mean([one[..., NORMAL] for one in frames[-NEWEST:]], axis=0) - before.mean(axis=0))
    return bool((press > np.maximum(limit[..., NORMAL], BEGINS * before.std(axis=0))).any())
