"""Detectors: run the program of a detector file on the planes of a finger, frame by frame."""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from operator import is_
from typing import Any

import numpy as np

from cnnsim.program.machine import UniversalMachine
from cnnsim.support import Flags, Floats
from tactile.events.detector_file import DetectorFile, EventRule
from tactile.events.planes import PlanePool
from tactile.events.tracker import Change, Tracker


@dataclass(frozen=True)
class Transition:
    """The begin or end of an event of a rule: ``onset`` and ``end`` [s], with what the outputs of the program add."""

    rule: EventRule
    change: Change
    onset: float
    end: float | None
    taxels: Flags | None
    direction: str
    sense: str


class Detector:
    """One detector on one finger, with the memory of its machine.

    A program runs on every frame. The run is skipped when its outputs cannot change: all its inputs are logic planes,
    they equal those of the previous frame, and the last run left the memory unchanged. A detector that ``publishes``
    writes its outputs to the pool as inputs of later detectors. Users' detectors do not, so they cannot replace a
    shipped plane.
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
        self._unnamed = dict[str, float]()  # onsets of lasting events whose kind is not known yet

    def update(self, t: float) -> list[Transition]:
        """Process the planes of the pool at ``t`` [s] and return the transitions of all rules."""
        ran = self._run()
        found = []
        for tracker in self._trackers:
            if not (ran or tracker.pending):
                continue
            rule, out = tracker.rule, self.outputs
            turn = tracker.update(t, _on(out[rule.when]), rule.unless is not None and _on(out[rule.unless]))
            if turn is not None:
                assert tracker.onset is not None
                found.append(self._named(self._transition(tracker, turn)))
                if turn == "ends":
                    tracker.onset = tracker.end = None
        return found

    def _named(self, what: Transition) -> Transition:
        """Return the transition; the first event of a ``kind_of`` gets the onset of the event whose kind it shows."""
        if what.change == "ends":
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

    def _transition(self, tracker: Tracker, turn: Change) -> Transition:
        rule, out = tracker.rule, self.outputs
        votes = [_count(out[name]) for name in rule.direction] or [0] * 4
        turns = [_count(out[name]) for name in rule.sense]
        sense = "" if not turns else "clockwise" if turns[0] >= turns[1] else "anticlockwise"
        taxels = out[rule.taxels] if rule.taxels else None
        assert tracker.onset is not None
        late = self._pool.late(rule.lag_of, tracker.onset)
        return Transition(
            rule,
            turn,
            max(tracker.onset - (rule.lag if late is None else late), 0.0),
            tracker.end if turn == "ends" else None,
            taxels,
            direction_of((votes[0] - votes[1], votes[2] - votes[3])),
            sense,
        )


def direction_of(along: tuple[float, float]) -> str:
    """Return the direction of a vector as "+x", "-y" or "+x -y"; an empty string for 0 or NaN."""
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
    """Whether two outputs are equal bit by bit; analog ones may hold NaN."""
    return bool(one.tobytes() == other.tobytes() if isinstance(one, np.ndarray) else one == other)
