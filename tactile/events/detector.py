"""Detectors at work: the program of a detector file on a finger's planes, frame by frame, and what it says."""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from operator import is_
from typing import Any

import numpy as np

from cnnsim.program.machine import UniversalMachine
from cnnsim.support import Flags, Floats
from tactile.events.detector_file import DetectorFile, EventRule
from tactile.events.planes import PlanePool
from tactile.events.tracker import Tracker, Turn


@dataclass(frozen=True)
class Happening:
    """That an event of a rule begins or ends: from ``onset`` to ``end`` [s]; what the program's outputs say of it."""

    rule: EventRule
    turn: Turn
    onset: float
    end: float | None
    taxels: Flags | None
    direction: str
    sense: str


class Detector:
    """One detector on one finger, with its machine's memory.

    A program sees every frame. It is not run where that could not tell: while its planes are those of the frame before,
    all of them logic, and its memory came out of the last run as it went in, its outputs are the same again. One that
    ``publishes`` gives its outputs to the pool, where the detectors that follow find them; users' detectors do not:
    whatever they call their planes, those of the shipped ones stay as they are.
    """

    def __init__(self, file: DetectorFile, machine: UniversalMachine, pool: PlanePool, *, publishes: bool) -> None:
        self._publishes = publishes
        self.file, self.outputs, self.changed = file, dict[str, Any](), False
        self._machine, self._pool = machine, pool
        machine.prepare(file.program, pool.shape)
        self._trackers = [Tracker(rule) for rule in file.rules]
        self._seen = -1
        self._fixed = False
        self._last: list[Floats] = []
        self._kept: dict[str, Any] = {}
        self._unnamed = dict[str, float]()  # onsets of events that last and of which no kind was told

    def update(self, t: float) -> list[Happening]:
        """Take the planes of the pool at ``t`` [s] and return what begins and ends."""
        ran = self._run()
        found = []
        for tracker in self._trackers:
            if not (ran or tracker.waits):
                continue
            rule, out = tracker.rule, self.outputs
            turn = tracker.update(t, _on(out[rule.when]), rule.unless is not None and _on(out[rule.unless]))
            if turn is not None:
                assert tracker.onset is not None
                found.append(self._named(self._happening(tracker, turn)))
                if turn == "ends":
                    tracker.onset = tracker.end = None
        return found

    def _named(self, what: Happening) -> Happening:
        """Return the first kind that is told of an event with the onset of that: its kind shows later than itself."""
        if what.turn == "ends":
            self._unnamed.pop(what.rule.kind, None)
            return what
        if what.rule.kind_of is not None:
            what = replace(what, onset=min(what.onset, self._unnamed.pop(what.rule.kind_of, what.onset)))
        self._unnamed[what.rule.kind] = what.onset
        return what

    def _run(self) -> bool:
        program, pool, self.changed = self.file.program, self._pool, False
        if self._fixed and pool.version == self._seen:
            return False
        inputs = [pool[name] for name in program.inputs]
        self._seen = pool.version
        if self._fixed and all(map(is_, inputs, self._last)):  # an analog plane is a new one in every frame
            return False
        before = self.outputs
        self.outputs = self._machine.run(program, **dict(zip(program.inputs, inputs, strict=True)))
        self.changed = not _alike(self.outputs, before)
        logic = all(map(pool.is_logic, program.inputs))
        kept = self._machine.kept(program) if logic and program.keep else {}
        self._fixed = logic and _alike(kept, self._kept)
        self._last, self._kept = inputs, kept
        for name, out in self.outputs.items() if self._publishes else ():
            if program.memory[name] == "llm":
                pool.set_logic(name, out)
            elif program.memory[name] == "wire":
                pool.set_logic(name, bool(out))
        self._seen = pool.version
        return True

    def _happening(self, tracker: Tracker, turn: Turn) -> Happening:
        rule, out = tracker.rule, self.outputs
        votes = [_count(out[name]) for name in rule.direction] or [0] * 4
        turns = [_count(out[name]) for name in rule.sense]
        sense = "" if not turns else "clockwise" if turns[0] >= turns[1] else "anticlockwise"
        taxels = out[rule.taxels] if rule.taxels else None
        assert tracker.onset is not None
        late = self._pool.late(rule.lag_of, tracker.onset)
        return Happening(
            rule,
            turn,
            max(tracker.onset - (rule.lag if late is None else late), 0.0),
            tracker.end if turn == "ends" else None,
            taxels,
            direction_of((votes[0] - votes[1], votes[2] - votes[3])),
            sense,
        )


def direction_of(along: tuple[float, float]) -> str:
    """Return "+x", "-y", "+x -y" of what points along x and y; nothing where it points nowhere."""
    most = max(map(abs, along))
    if not most > 0:  # NaN neither
        return ""
    return " ".join(f"{'+' if v > 0 else '-'}{axis}" for v, axis in zip(along, "xy", strict=True) if 2 * abs(v) > most)


def _on(value: Any) -> bool:
    return bool(value.any() if isinstance(value, np.ndarray) else value)


def _count(value: Any) -> int:
    return int(np.sum(value))


def _alike(one: Mapping[str, Any], other: Mapping[str, Any]) -> bool:
    return one.keys() == other.keys() and all(_is(one[name], other[name]) for name in one)


def _is(one: Any, other: Any) -> bool:
    """Whether two outputs, of which analog ones may hold NaN, are the same to the last bit."""
    return bool(one.tobytes() == other.tobytes() if isinstance(one, np.ndarray) else one == other)
