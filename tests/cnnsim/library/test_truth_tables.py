"""Every template that looks through a 3x3 window: all 512 windows at once, against the rule in words."""

import itertools
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from cnnsim import library
from cnnsim.backends import NAMES as NAMES_OF_BACKENDS
from cnnsim.library.catalogue import run
from cnnsim.transient import run_transient
from tests.oracles.pictures import black, plane
from tests.oracles.windows import LOGIC, RULES, Window

BACKENDS = NAMES_OF_BACKENDS


def all_windows() -> NDArray[np.bool_]:
    """The 512 black-and-white windows, (512, 3, 3)."""
    return np.array(list(itertools.product([False, True], repeat=9))).reshape(512, 3, 3)


def tiled(windows: NDArray[np.bool_]) -> NDArray[np.float64]:
    """All windows in one picture, 16 x 32 of them, a white line between each two."""
    tiles = np.pad(windows, ((0, 0), (0, 1), (0, 1))).reshape(16, 32, 4, 4)
    return plane(tiles.transpose(0, 2, 1, 3).reshape(64, 128))


def centres(picture: NDArray[Any]) -> NDArray[Any]:
    return picture[1::4, 1::4].ravel()


def expected(name: str) -> NDArray[np.float64]:
    windows = all_windows()
    cells = Window(*(windows[:, i, j] for i in range(3) for j in range(3)))
    return plane(np.asarray(RULES[name](cells), dtype=bool))


def test_the_picture_holds_every_window_once() -> None:
    picture = black(tiled(all_windows()))
    found = {picture[i : i + 3, j : j + 3].tobytes() for i in range(0, 64, 4) for j in range(0, 128, 4)}
    assert len(found) == 512


def test_every_uncoupled_binary_template_of_radius_one_has_a_rule() -> None:
    entries = [library.load(name) for name in library.names("uncoupled")]
    small = {e.name for e in entries if "binary" in e.tags and e.template.radius <= 1}
    assert small == (set(RULES) | set(LOGIC) | {"fill-black", "fill-white"}) - {"edge-gray"}


@pytest.mark.parametrize("backend", BACKENDS)
@pytest.mark.parametrize("name", RULES)
def test_all_512_windows(name: str, backend: str) -> None:
    y = centres(run(name, tiled(all_windows()), backend=backend).y)
    wrong = np.flatnonzero(~(y * expected(name) > 0.99))
    assert wrong.size == 0, f"{wrong.size} windows differ, the first: {all_windows()[wrong[0]].astype(int)}"


@pytest.mark.parametrize("name", [n for n in RULES if library.load(n).initial_state == "any"])
def test_an_initial_state_called_any_may_be_any(name: str) -> None:
    entry = library.load(name)
    picture = tiled(all_windows())
    start = np.random.default_rng(7).uniform(-1, 1, picture.shape)
    y = run_transient(entry.template, state=start, input=picture, boundary=entry.boundary).y
    assert (centres(y) * expected(name) > 0.99).all()


@pytest.mark.parametrize("backend", BACKENDS)
@pytest.mark.parametrize("name", LOGIC)
def test_logic_on_all_pairs(name: str, backend: str) -> None:
    u, x = np.array([[False, False, True, True]]), np.array([[False, True, False, True]])
    y = run(name, plane(u), state=plane(x), backend=backend).y
    assert (y * plane(LOGIC[name](u, x)) > 0.99).all()


@pytest.mark.parametrize("name", [n for n in RULES if n != "edge-gray"])
def test_the_margin_is_the_smallest_distance_from_a_tie(name: str) -> None:
    entry = library.load(name)
    a, windows = entry.template.self_feedback, plane(all_windows())
    drive = np.einsum("nij,ij->n", windows, entry.template.B) + entry.template.z
    if entry.initial_state == "picture":
        drive += (a - 1) * windows[:, 1, 1]
    assert entry.margin == pytest.approx(np.abs(drive).min() - max(1 - a, 0), abs=1e-9)


def turned(name: str, quarters: int) -> NDArray[np.float64]:
    """B of a template, turned clockwise."""
    return np.rot90(library.load(name).template.B, -quarters)


@pytest.mark.parametrize("family", ["skeleton-{}", "skeleton-4-connected-{}", "center-point-{}"])
@pytest.mark.parametrize("step", range(3, 9))
def test_steps_of_a_program_are_turns_of_the_first_two(family: str, step: int) -> None:
    first = family.format(2 - step % 2)
    assert np.array_equal(library.load(family.format(step)).template.B, turned(first, (step - 1) // 2))


@pytest.mark.parametrize(
    ("name", "first", "quarters"),
    [
        ("shift-e", "shift-n", 1),
        ("shift-s", "shift-n", 2),
        ("shift-w", "shift-n", 3),
        ("shift-se", "shift-ne", 1),
        ("contour-bottom", "contour-top", 2),
        ("contour-right", "contour-top", 1),
        ("contour-left", "contour-top", 3),
        ("vertical-skeleton-top", "horizontal-skeleton-left", 1),
        ("horizontal-skeleton-right", "horizontal-skeleton-left", 2),
        ("vertical-skeleton-bottom", "horizontal-skeleton-left", 3),
        ("horizontal-line-remover", "vertical-line-remover", 1),
        ("dilation-l-shape", "erosion-l-shape", 2),
        ("dilation-2x2", "erosion-2x2", 2),
    ],
)
def test_templates_that_are_turns_of_each_other(name: str, first: str, quarters: int) -> None:
    assert np.array_equal(library.load(name).template.B, turned(first, quarters))
