"""An error in one key of a file hides no other: any two errors are both reported, each with its line."""

import re
from itertools import combinations

import pytest

from cnnsim import InputError
from tests.kits.good_files import GOOD

MEANT = {  # by kind: lines where the other type has a meaning, or that are reported with the line of their table
    "template": ("A =", "weights ="),  # a matrix of one number
    "program": ("A =", "w =", "input =", "state =", "template =", "to ="),
    "detector": ("copy =", "to ="),
}
POSITIVE = {
    "description": ("baudrate", "youngs_modulus_mpa", "rows", "cols", "pitch_mm", "depth_mm", "thickness_mm",
                    "dead_band", "hysteresis", "contact_level"),
    "scene": ("rate_hz", "duration_s", "seed", "accuracy", "youngs_modulus_mpa", "full_scale", "rows", "cols",
              "pitch_mm", "depth_mm", "radius_mm", "length_mm", "friction", "speed_mm_s", "force_N", "stiffness_N_mm",
              "rms"),
    "calibration": ("depth_mm",),
    "taxels": ("rows", "cols"),
    "detector": ("confirm_ms", "release_ms", "lag_ms"),
    "template": ("duration", "margin", "step", "frame_time", "delay", "tolerance"),
    "layers": ("duration", "time_constant"),
    "program": ("duration",),
}  # fmt: skip
"""Keys of each kind whose numbers cannot be below 0."""


def lost(kind: str, wrong: dict[int, str]) -> list[tuple[str, ...]]:
    """Return the lines, one or two of a file, of which a message does not tell all when they hold these values."""
    text, read = GOOD[kind]
    lines = text.splitlines()
    read(text)
    found = []
    for at in [*((n,) for n in wrong), *combinations(wrong, 2)]:
        changed = [wrong[n] if n in at else line for n, line in enumerate(lines)]
        try:
            read("\n".join(changed) + "\n")
            told = ""
        except InputError as error:
            told = str(error)
        if not all(re.search(rf"\(line {n + 1}\)", told) for n in at):
            found.append(tuple(changed[n] for n in at))
    return found


@pytest.mark.parametrize("kind", GOOD)
def test_values_of_another_type(kind: str) -> None:
    wrong = {}
    for n, line in enumerate(GOOD[kind][0].splitlines()):
        key, equals, value = line.partition(" = ")
        if equals and not line.startswith(MEANT.get(kind, ("[",))):
            wrong[n] = f"{key} = 7.5" if value[0] in '"[' else f'{key} = "x"'
    assert len(wrong) >= 5
    assert lost(kind, wrong) == []


@pytest.mark.parametrize("kind", GOOD)
def test_numbers_below_0(kind: str) -> None:
    wrong = {
        n: f"{key} = -5"
        for n, line in enumerate(GOOD[kind][0].splitlines())
        if (key := line.partition(" = ")[0]) in POSITIVE[kind]
    }
    assert wrong
    assert lost(kind, wrong) == []
