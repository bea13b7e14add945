"""Defects of imported templates: known ones, differences from the library, and faults of the numbers."""

from collections.abc import Iterator
from functools import cache

import numpy as np

from cnnsim import library
from cnnsim.formats.differences import number_differences
from cnnsim.library.entry import LibraryEntry
from cnnsim.library.imported import Imported
from cnnsim.network import AnyTemplate, Template

_SMALL_MARGIN = 0.25  # what an analog chip of 7 or 8 bits cannot be trusted with


def defects(imported: Imported, source_name: str, system: str) -> list[str]:
    """Return the warnings for a template that comes from a ``system`` (CANDY, MATCNN, ...) as ``source_name``.

    They come from the table of known defects, from the library's own template of that name, and from the numbers.
    """
    found = [KNOWN[source_name.upper()]] if source_name.upper() in KNOWN else []
    if imported.missing:
        return found
    entry = counterpart(imported.network, source_name, system)
    return [*found, *_from_numbers(imported, verified=entry is not None), *(compare(imported, entry) if entry else ())]


def counterpart(template: AnyTemplate, source_name: str, system: str) -> LibraryEntry | None:
    """Return our own template that goes by that name in that system, of several the nearest in numbers."""
    wanted = {source_name.upper(), f"{source_name} ({system})".upper()}
    same = [entry for entry in _shipped() if wanted & {alias.upper() for alias in entry.aliases}]
    return min(same, key=lambda entry: len(list(number_differences(template, entry.network))), default=None)


@cache
def _shipped() -> tuple[LibraryEntry, ...]:
    """Return the shipped templates, without those in users' folders."""
    return tuple(library.load_file(path) for path in sorted(library.folder().glob("*.toml")))


def compare(imported: Imported, entry: LibraryEntry) -> Iterator[str]:
    """Yield what differs from the library's verified template."""
    why = f": {entry.note}" if entry.note else ""
    if differences := list(number_differences(imported.network, entry.network)):
        yield f"differs from the library's {entry.name}: {', '.join(differences)}{why}"
        return
    settings = []
    if imported.boundary != entry.boundary:
        settings.append(f"boundary {imported.boundary}, not {entry.boundary}")
    state = 0 if imported.initial_state == "any" else imported.initial_state
    if entry.initial_state not in ("any", state, imported.initial_state):
        settings.append(f"initial state {imported.initial_state}, not {entry.initial_state}")
    if imported.duration != entry.duration and entry.duration != "settled":
        settings.append(f"running time {imported.duration}, not {entry.duration} time constants")
    discrete = imported.cell.model == "discrete-time"
    if discrete != (entry.cell.model == "discrete-time"):
        settings.append("discrete time, not continuous" if discrete else "continuous time, not discrete")
    if settings:
        yield f"the numbers are those of the library's {entry.name}, the setting is not ({'; '.join(settings)}){why}"
    elif entry.margin is not None and entry.margin < _SMALL_MARGIN:
        yield f"nearly critical: the margin of the library's {entry.name} is {entry.margin:g}{why}"


def _from_numbers(imported: Imported, verified: bool) -> Iterator[str]:
    """Yield warnings that follow from the numbers; a warning about the boundary only if ``verified`` is false."""
    template = imported.network
    if isinstance(template, Template) and template.linear and template.uncoupled and template.control_taps:
        a, reach = template.self_feedback, float(np.abs(template.B).sum())
        if a >= 1 and abs(template.z) - reach - (a - 1) > 0:
            colour = "black" if template.z > 0 else "white"
            yield f"the output is {colour} for every input and every initial state"
    if not verified and not template.uncoupled and any(y == 0 for y, _ in imported.boundary.constants):
        yield "coupled, with a boundary of 0: waves can hang or start at the rim; white outside (-1) is often needed"


KNOWN: dict[str, str] = {
    **dict.fromkeys(
        ("DEADENDH", "DEADENDV"),
        "both files are the same, and with z = -5.8 the output is white for every neighbourhood; black with at most "
        "one black neighbour wants a z between -4 and -3.5 with the picture as initial state",
    ),
    **dict.fromkeys(
        ("PROP1", "PROP2"),
        "without a CURRENT nothing moves: the library's trigger-wave (z > 0) and trigger-wave-white (z < 0) do",
    ),
    **dict.fromkeys(
        (f"CNTR{k}" for k in range(1, 9)),
        "run until it settles this coupled centre point template peels past the centre; use center-point-1 to -8",
    ),
    "CENTER": "run until they settle these coupled templates peel past the centre; use center-point-1 to -8",
    **dict.fromkeys(
        ("T1_RACC3", "T2_RACC3", "T3_RACC3", "T4_RACC3", "TX_RACC3", "TX_RACC5", "TX_HCLC"),
        "learned texture template without a running time; its task could be reproduced in part, at a time of 6 to 10",
    ),
    **dict.fromkeys(("PARITY", "MAJVOT2"), "the printed functions do not do what its header describes"),
    "HISTOGRAM": "works in discrete time with a black west border only; in continuous time it stalls half-way",
    "HISTOGR": "works in discrete time with a black west border only; in continuous time it stalls half-way",
    "CONCCONT": "works in discrete time only; in continuous time its rings are distorted",
    **dict.fromkeys(
        ("HERRING", "HERRING1", "HERRING2", "HERRING3"), "never settles; read its output after 2 to 8 time constants"
    ),
    "LIFE_1L": 'wants the piecewise linear output: cell = { model = "discrete-time", characteristic = "clip" }',
    "TRACE": "critical: a visited cell has a drive of exactly 0 in layer 2; z = 2.5 there would hold it",
    "GLOB_CONN": "does not delete exactly the marked object; use connectivity",
    **dict.fromkeys(
        ("FUZZY", "MTYPE", "MTYPE0", "MTYPE1", "BPF", "TRW", "THRESAD"), "its task is not known well enough"
    ),
    **dict.fromkeys(
        (f"SKL{k}" for k in range(1, 9)), "the loop of eight does not keep the topology; use skeleton-1 to -8"
    ),
}
"""Published templates that do not do what they say, by the name of their file: found by simulation. Those that the
library has in a corrected form are found by `compare`."""
