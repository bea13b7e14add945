"""The library's non-linear and discrete-time templates against ranks and rules; what is wrong in their files."""

from typing import Any

import numpy as np
import pytest

from cnnsim import InputError, library, run
from cnnsim.network import Table, Term
from cnnsim.program.file import load_program
from cnnsim.program.machine import UniversalMachine
from tests.oracles import kinds
from tests.oracles.pictures import Case, black, plane

both = pytest.mark.parametrize("backend", ["reference", "cpu"])

SHAPES = [(1, 1), (1, 9), (2, 2), (7, 8)]

BINARY = [
    "row-histogram", "life-discrete", "life-discrete-1-layer", "discrete-connected-components", "discrete-hole-filler",
    "discrete-edge", "concentric-contour", "discrete-increase", "discrete-decrease",
]  # fmt: skip

GRAY = {
    "average-gradient": 1e-3, "mean-difference": 1e-3, "edge-enhancement": 1e-3, "global-maximum": 1e-2,
    "global-maximum-matcnn": 1e-2, "global-minimum": 1e-2, "gray-dilation": 0.021, "gray-erosion": 0.021,
}  # fmt: skip

DECIDED = [
    "gradient-threshold", "gradient-threshold-bistable", "flat-places", "gray-contour", "local-maxima",
    "local-maxima-matcnn", "local-minima", "gray-line-30-60", "gray-diagonal-nw-se", "gray-diagonal-ne-sw",
]  # fmt: skip


@both
@pytest.mark.parametrize("name", BINARY)
def test_binary_definitions(name: str, backend: str) -> None:
    for shape in SHAPES:
        rng = np.random.default_rng([*name.encode(), *shape])
        for share in (0.3, 0.6):
            picture = plane(rng.random(shape) < share)
            answer = kinds.ANSWERS[name](Case(picture, picture))
            assert np.array_equal(np.sign(run(name, picture, backend=backend).y), answer), picture


@both
@pytest.mark.parametrize("name", [*GRAY, *DECIDED])
def test_gray_definitions(name: str, backend: str) -> None:
    for shape in SHAPES:
        picture = np.random.default_rng([*name.encode(), *shape]).uniform(-0.9, 0.9, shape)
        y, answer = run(name, picture, backend=backend).y, kinds.ANSWERS[name](Case(picture, picture))
        if name in GRAY:
            assert np.abs(y - answer)[1:-1, 1:-1].max(initial=0) <= GRAY[name]
            at_most = GRAY[name] * (8 if name in ("gray-dilation", "gray-erosion") else 1)  # the border repeats cells
            assert np.abs(y - answer).max() <= at_most
        else:
            assert (y * answer > 0.9).all(), picture


@both
@pytest.mark.parametrize("z", [0, 2, -2, 3, -3])
def test_the_median_and_the_ranks_beside_it(z: int, backend: str) -> None:
    picture = np.random.default_rng(z + 9).uniform(-0.9, 0.9, (9, 10))
    y = run("median", picture, bias=np.full(picture.shape, z), backend=backend).y
    ordered = np.sort(kinds.neighbours(picture, None), axis=0)
    first = {0: 3, 2: 5, -2: 1, 3: 6, -3: 0}[z]
    low, high = ordered[first], ordered[first + 1]
    inside = (slice(1, -1), slice(1, -1))  # the border repeats cells, and jumps are larger there
    assert (y >= low - 0.021)[inside].all()
    assert (y <= high + 0.021)[inside].all()


@pytest.mark.parametrize("name", ["perona-malik", "perona-malik-4"])
def test_anisotropic_diffusion_smooths_and_keeps_the_edge(name: str) -> None:
    rng = np.random.default_rng(5)
    clean = np.where(np.arange(16) < 8, -0.6, 0.6) * np.ones((16, 1))
    y = run(name, clean + rng.normal(0, 0.05, clean.shape)).y
    assert (y - clean).std() < 0.3 * 0.05
    assert (y[:, 8] - y[:, 7]).min() > 1.15


@both
def test_the_wave_arrives_at_the_distance_in_steps(backend: str) -> None:
    rng = np.random.default_rng(6)
    walls = rng.random((12, 13)) < 0.45
    start = np.zeros_like(walls)
    start[tuple(np.argwhere(~walls)[0])] = True
    for count in (1, 3, 8, 20):
        y = run("pathfinder-wave", plane(walls), state=plane(start), duration=count, backend=backend).y
        assert np.array_equal(black(y), kinds.arrival(walls, start, count))


@both
def test_concentric_contour_needs_discrete_time(backend: str) -> None:
    square = -np.ones((11, 11))
    square[1:10, 1:10] = 1
    rings = run("concentric-contour", square, backend=backend).y
    assert np.array_equal(rings[5], [-1, 1, -1, 1, -1, 1, -1, 1, -1, 1, -1])
    distance = np.hypot(*np.mgrid[-8:9, -8:9])
    disc = np.where(distance < 7.3, 1.0, -1.0)
    rings = run("concentric-contour", disc, backend=backend).y
    smooth = run("concentric-contour", disc, cell="chua-yang", duration=60.0, backend=backend).y
    assert (np.sign(smooth) != rings).sum() > 10


def test_the_library_says_what_is_wrong_with_a_file(tmp_path: Any) -> None:
    good = (library.folder() / "average-gradient.toml").read_text()
    for old, new, message in [
        ("u_kl - u_ij", "u - u", "argument"),
        ("{ linear", "{ cubic", "table"),
        ("of =", "off =", "term 0"),
        ('input = "picture"', 'input = "none"', "reads u"),
    ]:
        (tmp_path / "average-gradient.toml").write_text(good.replace(old, new, 1))
        with pytest.raises(InputError, match=message):
            library.load_file(tmp_path / "average-gradient.toml")


def test_a_term_checks_itself() -> None:
    for wrong in ({"weights": np.ones((2, 2))}, {"of": "w_kl"}, {"delay": -1.0}, {"layer": -1}, {"table": [0, 1]}):
        with pytest.raises(InputError, match="wanted"):
            Term(**{"weights": [[1.0]], **wrong})  # type: ignore[arg-type]  # on purpose
    with pytest.raises(InputError, match="wanted"):
        Table("linear", (1.0, 0.0), (0.0, 0.0))


@both
def test_programs_run_the_new_kinds(backend: str, tmp_path: Any) -> None:
    """Holes filled in discrete time, then the median of the picture, and a sequence that a step cannot have."""
    text = """name = "mixed"
inputs = ["picture"]
outputs = ["filled", "smooth"]
lam = ["picture", "smooth"]
llm = ["filled"]
[[step]]
template = "discrete-hole-filler"
input = "picture"
to = "filled"
[[step]]
template = "median"
input = "picture"
to = "smooth"
"""
    (tmp_path / "mixed.toml").write_text(text)
    rng = np.random.default_rng(8)
    picture = plane(rng.random((9, 9)) < 0.6)
    found = UniversalMachine(backend, "float64").run(load_program(tmp_path / "mixed.toml"), picture=picture)
    assert np.array_equal(plane(found["filled"]), kinds.flood_holes(Case(picture)))
    assert np.allclose(found["smooth"], run("median", picture, backend=backend, dtype="float64").y)
    (tmp_path / "film.toml").write_text(text.replace("median", "slow-motion"))
    with pytest.raises(InputError, match="sequence of pictures"):
        load_program(tmp_path / "film.toml")
    (tmp_path / "waves.toml").write_text(text.replace("median", "autowave"))
    with pytest.raises(InputError, match="has 2 layers"):
        load_program(tmp_path / "waves.toml")
