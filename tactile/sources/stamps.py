"""Checks of time stamps, and their repair by another clock of the same recording."""

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from cnnsim.support import Floats, InputError
from tactile.core.frame import Frame, TaxelArray

UNIX = 3 * 10**17
"""[ns] Smallest stamp that counts as Unix time: 1979."""
JUMP = 0.5
"""[s] Step of the stamps beyond that of another clock that counts as a jump."""
BACK = 1e-9
"""[s] Step back that is rounding."""


def settled(stamps: Floats, others: Mapping[str, Floats], what: str) -> tuple[Floats, str]:
    """Return increasing times (n,) [s], and a sentence on the repair, empty without one.

    Repeated stamps are kept. Stamps that are missing, zero, all equal, step back or jump against another clock are
    replaced by the first sound one of ``others`` (n,) [s]; ``what`` names the stamps in messages.

    Raises:
        InputError: the stamps have a fault, and there is no other sound clock.
    """
    fault = fault_of(stamps)
    sound = {name: one for name, one in others.items() if not fault_of(one)}
    if not fault and sound:
        name, other = next(iter(sound.items()))
        jumps = np.flatnonzero(np.diff(stamps) - np.diff(other) > JUMP)
        # a recording with pauses has them on all its clocks; one that counts samples has none
        if jumps.size and (np.diff(other) > 0).all() and name not in COUNTS:
            step = float(np.diff(stamps)[jumps[0]])
            fault = f"jump by {step:.3g} s at sample {int(jumps[0]) + 1}, which {name} do not"
    if not fault:
        return stamps, ""
    if not sound:
        wanted = "a time column that increases, or rate_hz, wanted"
        raise InputError(f"{what}: they {fault}, and there is no other clock; {wanted}")
    name, other = next(iter(sound.items()))
    return other, f"{what} {fault}; the times of {name} are used"


def in_order(
    frames: Sequence[Frame], arrays: tuple[TaxelArray, ...], where: str
) -> tuple[Sequence[Frame], tuple[str, ...]]:
    """Return the frames of a recording in the order of their times, and sentences on the repair of their stamps.

    Stamps of a finger that step back are replaced by the device's clock, or by the sequence numbers.

    Raises:
        InputError: as ``settled``.
    """
    times = np.array([frame.t for frame in frames])
    if not (np.diff(times) < 0).any():
        return frames, ()
    fingers, notes = np.array([frame.finger for frame in frames]), []
    for number, array in enumerate(arrays):
        mine = fingers == number
        if not mine.any():
            continue
        clocks = [(frame.t_device, frame.sequence) for frame in frames if frame.finger == number]
        (device, sequence), stamps = np.array(clocks, np.float64).T, times[mine]
        others = {"the device": device - device[0], "the sequence numbers": counted(sequence, stamps)}
        others = {name: stamps[0] + one for name, one in others.items()}
        times[mine], note = settled(stamps, others, f"{where}: t_s of finger {array.name!r}")
        notes.append(note)
    if not any(notes):
        notes.append(f"{where}: fingers one after the other; their frames are merged by time")
    order = np.argsort(times, kind="stable").tolist()
    return [replace(frames[k], t=float(times[k])) for k in order], tuple(filter(None, notes))


COUNTS = ("the sequence numbers", "rate_hz")
"""Clocks that only count samples."""


def fault_of(stamps: Floats) -> str:
    """Return what is wrong with stamps (n,) [s], an empty text if nothing is."""
    missing = ~np.isfinite(stamps)
    if missing.any():
        return f"are missing or zero in {int(missing.sum())} of {stamps.size} samples"
    if stamps.size < 2:
        return ""
    if stamps.size > 2 and (stamps == stamps[0]).all():
        return f"are all {stamps[0]:g}"
    steps = np.diff(stamps)
    back = np.flatnonzero(steps < -BACK)
    zeros = int((stamps == 0).sum())
    if zeros and back.size and (stamps[back + 1] == 0).any():
        return f"are zero in {zeros} of {stamps.size} samples"
    if back.size:
        more = f" and {back.size - 1} times more" if back.size > 1 else ""
        return f"step back by {-float(steps[back[0]]):.3g} s at sample {int(back[0]) + 1}{more}"
    return ""


def counted(sequence: Floats, stamps: Floats) -> Floats:
    """Return times [s] of sequence numbers: their count times the median step of the stamps."""
    steps = np.diff(stamps[np.isfinite(stamps)])
    steps, counts = steps[steps > 0], np.diff(sequence)
    each = float(np.median(counts[counts > 0])) if (counts > 0).any() else 1.0
    step = float(np.median(steps)) if steps.size else np.nan
    return np.asarray((sequence - sequence[0]) * step / each, np.float64)
