"""Score of sequences labelled slip or no slip: accuracy and delay of the detection."""

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from cnnsim.support import Flags, Floats, InputError
from cnnsim.support.array_files import read_npz_arrays
from tactile import pipeline
from tactile.core.frame import Frame
from tactile.core.source import FrameStream, Provenance
from tactile.events.event import EventLog
from tactile.settings import Settings
from tactile.wire.arrange import Arrange
from tactile.wire.description import Description
from tactile.wire.reading import Reading

KINDS = ("pull", "twist", "slip", "incipient_slip")
"""Kinds of events that mean that a held object moves against the skin, or is about to."""
QUIET = 30
"""Number of initial frames without slip."""
SMOOTH, BROAD = 9, 25
"""Odd numbers of frames of the moving averages for the onset of a change and for its steepest rise."""
MISFIT = 0.4
"""Relative root mean square residual above which a located load does not explain the readings."""
BASELINE = 8.0
"""Threshold of the plain detector on the norm of all channels [sigma]."""


@dataclass(frozen=True)
class Sequences:
    """Readings ``signal`` (n, frames, chips, 3) in the unit of the wire, ``rate`` [Hz], and labels ``slips`` (n,).

    ``onset`` (n,) [s] of the slips, NaN if unknown.
    """

    signal: Floats
    slips: Flags
    rate: float
    onset: Floats

    def source(self, number: int, description: Description, gain: float = 1.0) -> FrameStream:
        """Return one sequence as frames of the described boards, all readings times a factor."""
        arrange = Arrange(description)
        frames: list[Frame] = []
        for n, chips in enumerate(self.signal[number] * gain):
            frames += arrange(Reading(chips, n), n / self.rate)
        known = Provenance(untared=True, description=description.text)
        title = f"sequence {number}"
        return FrameStream(title, description.arrays, description.modulus, len(frames), frames, known)


def read_sequences(path: Path, description: Description, rate: float | None = None) -> Sequences:
    """Return the sequences of an NPZ file.

    ``signal`` (sequences, frames, channels): boards in the order of the description, chips, x, y, z; ``slip``
    (sequences,) yes or no; optionally ``onset_s`` (sequences,) and ``rate_hz``, which ``rate`` replaces. An unknown
    onset is where the signal begins to change.

    Raises:
        InputError: no such file, a missing array or one of another shape.
    """
    found = read_npz_arrays(path, "file of sequences", ("signal", "slip", "onset_s", "rate_hz"))
    chips = sum(board.chips for board in description.boards)
    signal, slips = found.get("signal", np.empty(0)), found.get("slip", np.empty(0))
    if signal.ndim != 3 or signal.shape[2] != 3 * chips or slips.shape != signal.shape[:1] or not len(slips):
        raise InputError(
            f"{path}: signal of shape {signal.shape}, slip of {slips.shape}; (sequences, frames, {3 * chips}), as"
            f" {chips} chips have channels, and (sequences,) wanted"
        )
    if signal.shape[1] <= 2 * BROAD + QUIET:
        raise InputError(f"{path}: sequences of {signal.shape[1]} frames; more than {2 * BROAD + QUIET} wanted")
    if rate is None and "rate_hz" not in found:
        raise InputError(f"{path}: no rate_hz; rate_hz or --rate wanted")
    hertz = float(rate if rate is not None else found["rate_hz"])
    if not 0 < hertz < np.inf:
        raise InputError(f"{path}: rate of {hertz} Hz; a positive number wanted")
    readings = signal.astype(float)
    known = found.get("onset_s", np.full(slips.shape, np.nan)).astype(float)
    begins = np.array([onset(norm) / hertz for norm in _norms(readings)])
    return Sequences(
        readings.reshape(*signal.shape[:2], chips, 3), slips.astype(bool), hertz,
        np.where(np.isfinite(known), known, begins),
    )  # fmt: skip


def _norms(signal: Floats) -> Floats:
    """Return (n, frames) the norm of all channels minus their initial mean."""
    norms: Floats = np.linalg.norm(signal - signal[:, :QUIET].mean(axis=1, keepdims=True), axis=2)
    return norms


def onset(norm: Floats) -> int:
    """Return the frame at which a signal (frames,) begins to grow, from the whole signal.

    It is the least-squares fit of a constant followed by a rising straight line, up to the steepest rise of the signal.
    """
    smooth, broad = (np.convolve(np.pad(norm, n // 2, mode="edge"), np.ones(n) / n, "valid") for n in (SMOOTH, BROAD))
    top = int(np.argmax(np.gradient(broad)[BROAD // 2 : -BROAD // 2])) + BROAD // 2
    part = smooth[: top + BROAD // 2]
    t, level = np.arange(len(part)), part - part.mean()
    left = []
    for start in range(max(top, 1)):
        rise = np.maximum(t - start, 0.0)
        rise -= rise.mean()
        left.append(float(level @ level - (rise @ level) ** 2 / (rise @ rise)))
    return int(np.argmin(left))


def plain_detector(norm: Floats) -> int | None:
    """Return the first frame whose norm exceeds `BASELINE` times the initial noise; None without one."""
    noise = float(np.sqrt((norm[:QUIET] ** 2).mean()))
    passed = np.flatnonzero(norm[QUIET:] > BASELINE * noise)
    return int(passed[0]) + QUIET if len(passed) else None


@dataclass
class Verdicts:
    """Decisions on sequences with a factor on their readings: counts of right and wrong ones, and delays [s]."""

    right: int = 0
    false: int = 0
    missed: int = 0
    still: int = 0
    onsets: list[float] = field(default_factory=list)
    told: list[float] = field(default_factory=list)

    def add(self, slips: bool, known: float, found: tuple[float, float] | None) -> None:
        """Count a sequence that ``slips`` from ``known`` [s] on, or not; ``found``: onset and time of the report."""
        self.right += slips is (found is not None)
        self.false += not slips and found is not None
        self.missed += slips and found is None
        self.still += not slips
        if slips and found is not None:
            self.onsets.append(found[0] - known)
            self.told.append(found[1] - known)

    def plain(self) -> dict[str, Any]:
        """Return all as plain data; delays as their 5, 50 and 95 % points [s]."""
        count = self.right + self.false + self.missed
        points = {
            name: [float(point) for point in np.percentile(late, (5, 50, 95))] if late else None
            for name, late in (("onset_error_s", self.onsets), ("told_after_s", self.told))
        }
        return {
            "sequences": count, "accuracy": round(self.right / count, 4),
            "false_rate": round(self.false / self.still, 4) if self.still else None,
            "false": self.false, "missed": self.missed, **points,
        }  # fmt: skip


@dataclass
class _Followed:
    """Events of one sequence, and the number of contact frames whose located load explains the readings."""

    log: EventLog = field(default_factory=EventLog)
    explained: int = 0
    pressed: int = 0

    def __call__(self, report: pipeline.FrameReport) -> None:
        self.log.add(report.events, report.ended)
        if report.array.quantity != "force" and report.code.contact.any():
            self.pressed += 1
            self.explained += report.load.misfit <= MISFIT


def score_sequences(
    sequences: Sequences, description: Description, settings: Callable[[FrameStream], Settings],
    gains: Sequence[float] = (1.0,), kinds: Iterable[str] = KINDS,
    watch: Callable[[list[int]], Iterable[int]] = iter,
) -> dict[str, Any]:  # fmt: skip
    """Return the decisions on the sequences for each factor on the readings, and for the plain detector.

    A sequence is a slip if an event of one of the ``kinds`` is reported; ``watch`` passes the numbers of the sequences
    on and may show progress. ``explained``: share of the contact frames in which the located load explains most of the
    readings; None for force arrays. A small share means that gains, axes or depth of the array are wrong.

    Raises:
        InputError: uncalibrated readings described as strain or stress.
    """
    kinds = tuple(kinds)
    for board in description.boards:
        if board.array.quantity != "force" and board.array.name in description.uncalibrated:
            raise InputError(
                f"finger {board.array.name!r}: {description.wire.name} sends microtesla, called {board.array.quantity}"
                " without gains; gains = [shear, normal] per uT wanted, or, where they are unknown, quantity ="
                ' "force": events use the noise only'
            )
    explained = pressed = 0
    found = {f"x {gain:g}": Verdicts() for gain in gains} | {"baseline: norm": Verdicts()}
    norms = _norms(sequences.signal.reshape(*sequences.signal.shape[:2], -1))
    for number in watch(list(range(len(sequences.slips)))):
        slips, known = bool(sequences.slips[number]), float(sequences.onset[number])
        for gain in gains:
            source = sequences.source(number, description, gain)
            followed = _Followed()
            pipeline.run(source, settings(source), [followed])
            explained, pressed = explained + followed.explained, pressed + followed.pressed
            told = [event for event in followed.log.events if event.kind in kinds]
            first = (min(event.t for event in told), min(event.told for event in told)) if told else None
            found[f"x {gain:g}"].add(slips, known, first)
        passed = plain_detector(norms[number])
        when = None if passed is None else passed / sequences.rate
        found["baseline: norm"].add(slips, known, None if when is None else (when, when))
    share = round(explained / pressed, 4) if pressed else None
    readings = {name: one.plain() for name, one in found.items()}
    return {"kinds": list(kinds), "explained": share, "readings": readings}
