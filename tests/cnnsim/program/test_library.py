"""Every program of the library against an answer found another way, on every backend and from 1 x 1 cells up."""

import tomllib
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from cnnsim import library
from tests.kits.program_cases import BACKENDS, TINY, Draw, cell, check, coarse, few, gray, picture, planes
from tests.oracles import programs as oracle
from tests.oracles.mazes import shortest_paths, without_dead_ends
from tests.oracles.programs import SKELETONS
from tests.oracles.sequences import SEQUENCES

CASES: dict[str, tuple[dict[str, Draw], Callable[..., Any]]] = {
    "opening": ({"picture": picture}, oracle.opening),
    "closing": ({"picture": picture}, oracle.closing),
    "thinning": ({"picture": picture}, oracle.thinning),
    "areas": ({"picture": picture}, oracle.areas),
    "euler-number": ({"picture": picture}, oracle.euler),
    "count-objects": ({"picture": picture}, oracle.objects),
    "count-holes": ({"picture": picture}, oracle.holes),
    "count-runs": ({"picture": picture}, oracle.runs),
    "size-sorting": ({"picture": picture}, oracle.sizes),
    "size-band-contour": ({"picture": picture}, oracle.band),
    "object-isolation": ({"picture": picture, "marker": few}, oracle.isolated),
    "maze-path": ({"walls": picture, "ends": few}, without_dead_ends),
    "maze-shortest-path": ({"walls": picture, "start": cell, "goal": cell}, shortest_paths),
    "life": ({"picture": picture}, oracle.life),
    "gray-opening": ({"picture": gray}, oracle.gray_opening),
    "gray-closing": ({"picture": gray}, oracle.gray_closing),
    "gray-gradient": ({"picture": gray}, oracle.gray_gradient),
    "median": ({"picture": gray}, oracle.median),
    "rank-order": ({"picture": coarse}, oracle.ranked),
}
"""Programs with an exact answer: how their inputs are drawn, and the oracle."""

BY_THEIR_OWN_TESTS = {"halftone-and-back", "texture-segmentation"}

TOUCH = {
    "contact-blob",
    "slip-front",
    "shear-flow",
    "coherent-shear",
    "onset-wave",
    "comparators",
}  # tests/tactile/events/test_programs.py

PIPELINE = {"event-code", "locate-strain", "locate-stress"}
"""In tests/tactile: events/test_code.py, inverse/test_taxel.py."""

FILES = sorted((library.folder() / "programs").glob("*.toml"))


def test_every_program_has_an_oracle() -> None:
    tested = {*CASES, *SKELETONS, *SEQUENCES, *BY_THEIR_OWN_TESTS, *TOUCH, *PIPELINE}
    assert {path.stem for path in FILES} == tested


@pytest.mark.parametrize("path", FILES, ids=[path.stem for path in FILES])
def test_a_file_says_what_a_user_needs(path: Path) -> None:
    text = path.read_text(encoding="utf-8")
    data = tomllib.loads(text)
    assert data["name"] == path.stem
    assert data["summary"].endswith(".")
    assert data["reference"]
    if path.stem not in PIPELINE | {"opening"}:
        comment = text.partition("\nname ")[0]
        assert all(line.startswith("# ") for line in comment.splitlines())
        assert "Limit" in comment or "for every picture" in comment  # what it cannot do


@pytest.mark.parametrize("backend", BACKENDS)
@pytest.mark.parametrize("name", CASES)
@settings(max_examples=20)
@given(data=st.data())
def test_program(backend: str, name: str, data: st.DataObject) -> None:
    kinds, answer = CASES[name]
    check(backend, name, data.draw(planes(kinds)), answer)


@pytest.mark.parametrize("backend", BACKENDS)
@pytest.mark.parametrize("name", CASES)
def test_program_on_the_smallest_grids(backend: str, name: str) -> None:
    kinds, answer = CASES[name]
    for shape in TINY:
        for seed in range(3):
            rng = np.random.default_rng(seed)
            check(backend, name, {key: kind(rng, shape) for key, kind in kinds.items()}, answer)


@pytest.mark.parametrize(("name", "parameters"), [
    ("life", {"generations": 4}),
    ("size-sorting", {"medium": 1, "large": 3}),
    ("size-band-contour", {"at_least": 2, "too_large": 3}),
    ("gray-opening", {"radius": 2}),
    ("gray-closing", {"radius": 3}),
    *(("rank-order", {"rank": rank}) for rank in (1, 2, 3, 4, 6, 7, 8, 9)),
])  # fmt: skip
@settings(max_examples=20)
@given(data=st.data())
def test_program_with_other_parameters(name: str, parameters: dict[str, float], data: st.DataObject) -> None:
    kinds, answer = CASES[name]
    check("cpu", name, data.draw(planes(kinds, longest=16)), answer, **parameters)
