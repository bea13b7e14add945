"""Stillness of a block of frames: whether the array moves or is touched, or only has slow noise."""

from dataclasses import dataclass

import numpy as np

from cnnsim.support import Floats
from tactile.core.frame import NORMAL
from tactile.core.noise import Noise, median, spread

PARTS = 4
"""Parts of a block whose means are compared."""
MUCH = 4.0
"""Largest drift of a taxel that is increasingly pressed, over the limit. Half of the taxels may drift by the limit."""
WANDER = 7.0
"""Largest drift of a mean within a still block, over the taxel's jitter or noise within a part. A load that grows
linearly gives 8, slow noise mostly 3 to 6."""
NEWEST = 5
"""Number of newest frames that are compared with earlier ones; the same number before them is skipped."""
BEGINS = 8.0
"""Standard deviations by which a load must press a taxel at its onset."""


@dataclass(frozen=True)
class Stillness:
    """Whether a block is ``still``; ``far``: largest drift of a mean over the limit; ``first``: mean of its first part.

    ``within`` (rows, cols, 3): noise within the parts, without slow noise and growing loads.
    """

    still: bool
    far: float
    first: Floats
    within: Floats


def judge(block: Floats, noise: Noise, limit: Floats, inward: float | Floats) -> Stillness:
    """Return whether frames (n, rows, cols, 3) are still.

    Args:
        block: Frames; NaN where a taxel did not read.
        noise: Noise of these frames.
        limit: Dead bands (3,) or (rows, cols, 3) [unit of the frames], of which means may move by half.
        inward: Sign of a pressing load, one or (rows, cols).
    """
    split = np.array_split(block, PARTS)
    parts = np.array([np.nanmean(part, axis=0) for part in split])
    within = np.median([spread(part) for part in split], axis=0)
    least = np.maximum(limit / 2, WANDER * np.maximum(noise.jitter, within))
    # a taxel without readings is still; slow noise of some taxels is no motion of the array
    far = (parts.max(axis=0) - parts.min(axis=0)) / least
    pressed = (inward * (parts - parts[0])[..., NORMAL]).max(axis=0) > least[..., NORMAL]
    touched = bool((pressed & (far > MUCH).any(-1)).any())
    wanders = 2 * (far > 1).any(-1).sum() > max(far.shape[0] * far.shape[1], 2)
    # the sum shows a load that is within the noise of each taxel; a change common to most taxels is drift
    press = inward * block[..., NORMAL]
    alone = press - median(press.reshape(len(press), -1))[:, None, None]
    whole = [np.nansum(part, axis=(1, 2)) for part in np.array_split(alone, PARTS)]
    means = np.array([one.mean() for one in whole])
    bound = float(np.median(limit[..., NORMAL])) / 2 * alone[0].size ** 0.5
    grows = float((means.max() - means[0]) / max(bound, WANDER * float(np.median([spread(one) for one in whole]))))
    return Stillness(not (touched or wanders or grows > 1), max(float(far.max()), grows), parts[0], within)


def begins(frames: list[Floats], limit: Floats, inward: float | Floats) -> bool:
    """Return whether the newest frames press a taxel by more than the limit and the noise of the earlier frames."""
    before = np.array(frames[: -2 * NEWEST])[..., NORMAL]
    press = inward * (np.mean([one[..., NORMAL] for one in frames[-NEWEST:]], axis=0) - before.mean(axis=0))
    return bool((press > np.maximum(limit[..., NORMAL], BEGINS * before.std(axis=0))).any())
