"""Templates of the library on random pictures against what their definitions say, on every backend."""

import itertools
import re

import numpy as np
import pytest
from scipy import ndimage

from cnnsim import library
from cnnsim.backends import NAMES as BACKENDS
from cnnsim.library.catalogue import run
from cnnsim.network import fixed
from tests.kits.library import ANSWERS, SHAPES, pictures, shapes
from tests.oracles import binary, gray, wholes
from tests.oracles.pictures import CROSS, SQUARE, Case, Picture, Plane, black, plane
from tests.oracles.windows import Rule

ALONE = sorted(
    name
    for name in binary.ANSWERS
    if library.load(name).initial_state != "given" and name != "horizontal-line-detector"
)


@pytest.mark.parametrize("backend", BACKENDS)
@pytest.mark.parametrize("name", ALONE)
def test_binary_definitions_of_one_picture(name: str, backend: str) -> None:
    for picture in (one for shape in shapes(backend) for one in pictures(name, shape)):
        y = run(name, plane(picture), backend=backend).y
        assert (y * ANSWERS[name](Case(u=plane(picture))) > 0.99).all(), picture


def second_picture(name: str, first: Picture) -> Picture:
    """An initial state as the template wants it."""
    rng = np.random.default_rng([*name.encode(), first.size])
    if name in ("recall", "figure-reconstructor"):
        return first & (rng.random(first.shape) < 0.2)
    if name == "connectivity":
        return first & (rng.random(first.shape) < 0.9)
    other = np.asarray(rng.random(first.shape) < 0.5)
    return other & ~first if name.startswith(("masked-connected", "masked-shadow")) else other


@pytest.mark.parametrize("backend", BACKENDS)
@pytest.mark.parametrize("name", sorted(set(binary.ANSWERS) - set(ALONE) - {"horizontal-line-detector"}))
def test_binary_definitions_of_two_pictures(name: str, backend: str) -> None:
    for picture in (one for shape in shapes(backend) for one in pictures(name, shape)):
        state = second_picture(name, picture)
        y = run(name, plane(picture), state=plane(state), backend=backend).y
        assert (y * ANSWERS[name](Case(plane(picture), plane(state))) > 0.99).all(), picture


def test_the_scans_and_floods_agree_with_plain_loops() -> None:
    """The oracles that are clever are held to ones that are not."""
    rng = np.random.default_rng(5)
    for shape in SHAPES:
        picture = rng.random(shape) < 0.4
        rows = ["".join("#" if cell else "." for cell in row) for row in picture]
        assert [wholes.runs(row) for row in picture] == [len(re.findall("#+", row)) for row in rows]
        assert [row.sum() for row in wholes.count_right(picture)] == [len(re.findall("#+", r)) for r in rows]
        for i, j in itertools.product(range(shape[0]), range(shape[1])):
            assert wholes.shadow(picture, "left")[i, j] == picture[i, j:].any()
            assert wholes.shadow(picture, "right")[i, j] == picture[i, : j + 1].any()
            assert wholes.shadow(picture, "up")[i, j] == picture[i:, j].any()
            assert wholes.shadow(picture, "down")[i, j] == picture[: i + 1, j].any()


@pytest.mark.parametrize(
    ("name", "answer"),
    [
        ("erosion-cross", lambda p: ndimage.binary_erosion(p, CROSS)),
        ("dilation-cross", lambda p: ndimage.binary_dilation(p, CROSS)),
        ("erosion-square", lambda p: ndimage.binary_erosion(p, SQUARE, border_value=1)),
        ("dilation-square", lambda p: ndimage.binary_dilation(p, SQUARE)),
        ("erosion-l-shape", lambda p: ndimage.binary_erosion(p, [[0, 1, 0], [0, 1, 1], [0, 0, 0]])),
        ("dilation-l-shape", lambda p: ndimage.binary_dilation(p, [[0, 1, 0], [0, 1, 1], [0, 0, 0]])),
        ("dilation-2x2", lambda p: ndimage.binary_dilation(p, [[0, 1, 1], [0, 1, 1], [0, 0, 0]])),
        ("erosion-2x2", lambda p: ndimage.binary_erosion(p, [[0, 1, 1], [0, 1, 1], [0, 0, 0]])),
        ("erosion-horizontal", lambda p: ndimage.binary_erosion(p, [[1, 1, 1]])),
        ("majority", lambda p: ndimage.median_filter(p.astype(int), 3, mode="constant") > 0),
    ],
)
def test_morphology_is_that_of_scipy(name: str, answer: Rule) -> None:
    for picture in (one for shape in SHAPES for one in pictures(name, shape)):
        assert np.array_equal(black(run(name, plane(picture)).y), answer(picture))  # type: ignore[arg-type]


@pytest.mark.parametrize("shape", SHAPES)
def test_horizontal_lines_where_no_gap_is_a_single_pixel(shape: tuple[int, int]) -> None:
    rng = np.random.default_rng(shape)
    for _ in range(3):
        lines = []
        for _ in range(shape[0]):
            parts = ["".join(("#" * rng.integers(1, 4), "." * rng.integers(2, 4))) for _ in range(shape[1])]
            lines.append([cell == "#" for cell in "".join(parts)[: shape[1]]])
        picture = plane(np.array(lines))
        y = run("horizontal-line-detector", picture).y
        assert (y * ANSWERS["horizontal-line-detector"](Case(picture)) > 0.99).all()


FILTERS = [
    "edge-gray", "threshold", "threshold-zero", "copy", "average", "lowpass", "laplacian", "optimal-edge",
    "inverse-halftone-3x3", "inverse-halftone-5x5", "constrained-diffusion", "majority-vote-1",
]  # fmt: skip


@pytest.mark.parametrize("backend", BACKENDS)
@pytest.mark.parametrize("name", FILTERS)
def test_gray_definitions(name: str, backend: str) -> None:
    for shape in shapes(backend):
        picture = np.random.default_rng([*name.encode(), *shape]).uniform(-1, 1, shape)
        y = run(name, picture, backend=backend).y
        assert np.abs(y - ANSWERS[name](Case(picture))).max() < 1e-3, shape


@pytest.mark.parametrize("name", ["approximate-diagonal-detector", "muller-lyer"])
def test_large_windows_on_gray_pictures(name: str) -> None:
    rng = np.random.default_rng(3)
    picture = rng.choice([-1.0, 1.0], (9, 12)) * rng.uniform(0.9, 1.0, (9, 12))
    assert (run(name, picture).y * ANSWERS[name](Case(picture)) > 0.99).all()


@pytest.mark.parametrize("shape", SHAPES)
def test_diffusion_is_the_matrix_exponential(shape: tuple[int, int]) -> None:
    start = np.random.default_rng(shape).uniform(-1, 1, shape)
    for time in (0.5, 5.0):
        y = run("diffusion", start, duration=time, scheme="rk4", step=0.05).y
        assert np.abs(y - gray.heat(Case(x0=start), time)).max() < 1e-6
    assert abs(run("diffusion", start).y.mean() - start.mean()) < 1e-6


def anchors(shape: tuple[int, int], share: float) -> tuple[Plane, Picture]:
    rng = np.random.default_rng(shape)
    mask = np.asarray(rng.random(shape) < share)
    mask.flat[0] = True
    return np.where(mask, rng.uniform(-0.4, 0.4, shape), 0.0), mask


@pytest.mark.parametrize("shape", SHAPES)
@pytest.mark.parametrize(("name", "share"), [("laplace-solver", 0.2), ("surface-interpolation", 0.6)])
def test_surfaces_through_masked_cells(name: str, share: float, shape: tuple[int, int]) -> None:
    start, mask = anchors(shape, share)
    y = run(name, start, mask=mask).y
    assert np.abs(y - ANSWERS[name](Case(x0=start, mask=mask))).max() < 5e-3


@pytest.mark.parametrize("shape", SHAPES)
def test_poisson_with_a_random_load(shape: tuple[int, int]) -> None:
    load = np.random.default_rng(shape).uniform(-0.4, 0.4, shape)
    start = np.zeros(shape)
    y = run("poisson-solver", start, bias=load).y
    assert np.abs(y - ANSWERS["poisson-solver"](Case(x0=start, bias=load))).max() < 5e-3


def test_hole_filling_and_counting_need_white_outside() -> None:
    """The files depart from the printed boundary of 0; this is why."""
    holes, lines = plane(np.eye(6, dtype=bool)), plane(np.tile([True, True, False, False], (4, 1)))
    assert (run("hole-filler", holes, boundary=fixed(0)).y > -0.99).any()
    assert black(run("hole-filler", holes).y).sum() == 6
    assert (black(run("connected-components-horizontal", lines).y).sum(axis=1) == 1).all()
    tail = run("connected-components-horizontal", lines, boundary=fixed(0), duration=150.0).y
    assert not (black(tail).sum(axis=1) == 1).all()
