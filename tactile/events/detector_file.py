"""Detector files: an analogic program with a table of the events that its planes and registers mean."""

import re
from collections.abc import Collection, Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from string import Formatter
from typing import Any

from cnnsim import InputError
from cnnsim.library.folders import folder, folders, not_found, program_file, programs
from cnnsim.program.file import load_program, program_of
from cnnsim.program.program import Program
from cnnsim.support import naming
from cnnsim.support.error_list import ErrorList, read_all
from cnnsim.support.files import named_file
from cnnsim.support.toml_file import check_keys, line_of, located, read_toml, take, take_from_zero, take_tables
from cnnsim.support.toml_lines import without
from tactile.core.file_kinds import refuse_other_kind
from tactile.events.planes import LATE, NAMES

EVENT_KEYS = (
    "kind", "when", "words", "taxels", "direction", "sense", "confirm_ms", "unless", "release_ms", "lag_ms", "lag_of",
    "kind_of",
)  # fmt: skip
OF_THE_DATA = ("direction", "sense", "taxels", "of_taxels", "force_n", "shear_n")
"""Names allowed in braces in the words of an event; a slip also has ``length_mm``."""
OF_LOAD = "load"
"""Value of ``direction`` for the direction of the total tangential load."""
WAYS = ("right", "left", "down", "up")
TIMES = ("confirm_ms", "release_ms", "lag_ms")
KIND = re.compile(r"[a-z][a-z0-9_]*")
SHIPPED = ("contact", "tangential", "slip")
"""Shipped detectors in running order: a later one may read the outputs of an earlier one. A new one is one file in
``templates/programs/touch``, and its name here."""


@dataclass(frozen=True)
class EventRule:
    """How outputs of a detector map to an event.

    ``when``: plane (any cell black) or register (not 0) that is on while the event lasts. ``taxels``: plane of the
    taxels that take part. ``direction``: four planes or registers for +x, -x, +y, -y, of which the larger give the
    direction; with ``along_load`` the total tangential load gives it. ``sense``: two planes or registers, clockwise and
    anticlockwise in the picture. The event begins when ``when`` was on for ``confirm`` [s] and ends when it was off for
    ``release`` [s]. With ``unless`` it need not stay on, but ``unless`` must not come on in that time. ``lag`` [s], or
    the delay measured by ``lag_of``, is subtracted from the onset. The first event that is a ``kind_of`` another one
    takes over its onset.
    """

    kind: str
    when: str
    words: str
    taxels: str | None = None
    direction: tuple[str, ...] = ()
    sense: tuple[str, ...] = ()
    confirm: float = 0.0
    release: float = 0.0
    along_load: bool = False
    lag: float = 0.0
    lag_of: str | None = None
    unless: str | None = None
    kind_of: str | None = None

    @property
    def outputs(self) -> set[str]:
        """The outputs of the program that the rule reads."""
        single = {name for name in (self.taxels, self.unless) if name is not None}
        return {self.when, *self.direction, *self.sense, *single}


@dataclass(frozen=True)
class DetectorFile:
    """A program and the events it makes; no events for a plain program."""

    name: str
    program: Program
    rules: tuple[EventRule, ...]


def read_detector(name: str | Path, known: Collection[str] = NAMES) -> DetectorFile:
    """Return the detector of a file, or of that name in the library.

    Arguments: ``name`` of a file (.toml), of a detector (``programs/touch``) or of a program of the library, which
    makes no events; ``known``: the planes available as inputs.

    Raises:
        InputError: a missing file, faults in it, or an unknown input plane.
    """
    path = named_file(name)
    if not path.suffix:
        path = _named(str(name))
    table = read_toml(path, "detector or program file")
    refuse_other_kind(table, path, "detector")
    faults, rules = ErrorList(str(path)), list[EventRule]()
    with naming(path):
        events = take_tables(table, "event", "detector")
    for number, event in enumerate(events, 1):
        with faults.collecting():
            rules.append(_rule(event, f"event {number}"))
    with faults.collecting():
        program = _program(table, path)
        _check(program, rules, known)
    faults.raise_all()
    return DetectorFile(program.name, program, tuple(rules))


def users_detectors(names: Collection[str]) -> list[DetectorFile]:
    """Return the detectors and programs that a user names, which run next to the shipped ones.

    Raises:
        InputError: as `read_detector`; a name used twice, or a kind of event that another detector makes.
    """
    if not names:
        return []
    shipped, found = shipped_detectors(SHIPPED), list[DetectorFile]()
    known = (*NAMES, *(name for detector in shipped for name in detector.program.outputs))
    makers = {rule.kind: f"the shipped {detector.name!r}" for detector in shipped for rule in detector.rules}
    for name in names:
        detector = read_detector(name, known)
        if detector.name in (one.name for one in found):
            raise InputError(f"{name}: a program {detector.name!r} is given already; one program per name wanted")
        kinds = [rule.kind for rule in detector.rules]
        for n, kind in enumerate(kinds):
            if kind in makers or kind in kinds[:n]:
                maker = makers.get(kind, "another of its events")
                raise InputError(f"{name}: kind {kind!r} is made by {maker}; a kind of its own wanted")
        makers |= dict.fromkeys(kinds, f"{detector.name!r}")
        found.append(detector)
    return found


def shipped_detectors(names: Collection[str]) -> list[DetectorFile]:
    """Return detectors of the shipped library, which users' files of these names never replace."""
    found, known = [], [*NAMES]
    for name in names:
        found.append(read_detector(folder() / "programs" / "touch" / f"{name}.toml", known))
        known += found[-1].program.outputs
    return found


def _named(name: str) -> Path:
    found = {path.stem: path for place in folders() for path in (place / "programs" / "touch").glob("*.toml")}
    if name in found:
        return found[name]
    try:
        return program_file(name)
    except InputError as error:
        if found and "did you mean" not in str(error):
            raise not_found("detector or program", name, {**found, **programs()}, "cnnsim list --programs") from error
        raise


def _program(table: dict[str, Any], path: Path) -> Program:
    if "program" not in table:
        return program_of(without(table, "event"), {}, {}, path)
    check_keys(table, ("name", "summary", "reference", "program", "parameters", "event"), "detector", ("name", "event"))
    chosen = take(table, "program", str, "detector")
    beside = path.parent / chosen
    numbers = take(table, "parameters", dict, "detector", {})
    return load_program(beside if beside.suffix else chosen, parameters=numbers)


def _rule(table: dict[str, Any], where: str) -> EventRule:
    check_keys(table, EVENT_KEYS, where, ("kind", "when"))
    along = table["direction"] == OF_LOAD if "direction" in table else False
    confirm, release, lag = (partial(take_from_zero, table, key, where, 0.0) for key in TIMES)
    optional = partial(_optional, table, where=where)
    kind, when, words, direction, sense, confirmed, released, late, taxels, unless, lag_of, kind_of = read_all(
        where, lambda: _kind(table, where), lambda: take(table, "when", str, where), lambda: _words(table, where),
        lambda: () if along else _outputs(table, "direction", len(WAYS), where),
        lambda: _outputs(table, "sense", 2, where), confirm, release, lag,
        *(partial(optional, key) for key in ("taxels", "unless")), lambda: _lag_of(table, where),
        partial(optional, "kind_of"),
    )  # fmt: skip
    return EventRule(
        kind, when, words, taxels, direction, sense, confirmed * 1e-3, released * 1e-3, along, late * 1e-3, lag_of,
        unless, kind_of,
    )  # fmt: skip


def _kind(table: dict[str, Any], where: str) -> str:
    kind = take(table, "kind", str, where)
    if not KIND.fullmatch(kind):
        wanted = "lower-case letters, digits and _ wanted, such as 'two_blobs'"
        raise InputError(f"{where}: kind = {kind!r}; {wanted}{line_of(table, 'kind')}")
    return kind


def _words(table: dict[str, Any], where: str) -> str:
    kind = table.get("kind")
    words = take(table, "words", str, where, "") or str(kind).replace("_", " ")
    with located(table, "words"):
        try:
            data = (*OF_THE_DATA, *(("length_mm",) if kind == "slip" else ()))
            unknown = {name for _, name, _, _ in Formatter().parse(words) if name is not None} - set(data)
        except ValueError as error:
            raise InputError(f"{where}: words = {words!r}: {error}") from error
        if unknown:
            raise InputError(f"{where}: words name {', '.join(sorted(unknown))}; of {', '.join(data)} wanted")
    return words


def _outputs(table: dict[str, Any], key: str, count: int, where: str) -> tuple[str, ...]:
    names = take(table, key, list, where, [])
    if len(names) not in (0, count) or not all(isinstance(name, str) for name in names):
        raise InputError(f"{where}: {key} = {names!r}; {count} names of outputs wanted{line_of(table, key)}")
    return tuple(names)


def _optional(table: dict[str, Any], key: str, where: str) -> str | None:
    return take(table, key, str, where) if key in table else None


def _lag_of(table: dict[str, Any], where: str) -> str | None:
    lag_of = _optional(table, "lag_of", where)
    if lag_of not in (None, *LATE):
        wanted = f"one of {', '.join(LATE)} wanted, whose delay is measured"
        raise InputError(f"{where}: lag_of = {lag_of!r}; {wanted}{line_of(table, 'lag_of')}")
    return lag_of


def _check(program: Program, rules: Sequence[EventRule], known: Collection[str]) -> None:
    wrong = [plane for plane in program.inputs if plane not in known]
    if wrong:
        raise InputError(f"inputs {', '.join(wrong)}; of {', '.join(known)} wanted")
    for n, rule in enumerate(rules):
        if rule.kind_of is not None and rule.kind_of not in (before := [one.kind for one in rules[:n]]):
            raise InputError(
                f"event {rule.kind!r}: kind_of = {rule.kind_of!r}; an earlier event of the file wanted, of"
                f" {', '.join(before) or 'none'}"
            )
        missing = sorted(rule.outputs - set(program.outputs))
        if missing:
            raise InputError(
                f"event {rule.kind!r}: {', '.join(missing)}; of the outputs {', '.join(program.outputs)} wanted"
            )
        if rule.taxels is not None and program.memory[rule.taxels] != "llm":
            raise InputError(f"event {rule.kind!r}: taxels = {rule.taxels!r} is no logic plane; one in llm wanted")
        for key, name in (("when", rule.when), ("unless", rule.unless)):
            if name is not None and program.memory[name] == "lam":
                raise InputError(f"event {rule.kind!r}: {key} = {name!r} is analog; a logic plane or a register wanted")
