"""Margins and tolerated errors against brute force; curves that can be reproduced."""

import itertools
import json
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from click.testing import CliRunner
from PIL import Image

from cnnsim import Template, library
from cnnsim.cli.robust import robust
from cnnsim.network import AnyTemplate, layered
from cnnsim.network.cell import output, uncoupled_state
from cnnsim.prototyping.robust.disturb import quantised, with_relative_errors
from cnnsim.prototyping.robust.error_rate import error_rate_of, final_colour, shown_to
from cnnsim.prototyping.robust.margin import margin_of, tolerated_error
from cnnsim.prototyping.robust.robust import BITS, NOISES, SIGMAS, measure
from cnnsim.transient import run_transient

WITH_MARGIN = [name for name in library.names("binary") if library.load(name).margin is not None]
UNCOUPLED = [name for name in WITH_MARGIN if library.load(name).template.uncoupled]


@pytest.mark.parametrize("name", WITH_MARGIN)
def test_the_margin_is_that_of_the_file(name: str) -> None:
    found = margin_of(library.load(name))
    assert found.value == pytest.approx(library.load(name).margin, abs=1e-9)
    assert found.exact is library.load(name).template.uncoupled


@pytest.mark.parametrize(
    "name", ["average", "diffusion", "halftone-5x5", "poisson-solver", "median", "autowave", "discrete-edge"]
)
def test_a_margin_does_not_apply_to_grey_templates(name: str) -> None:
    found = margin_of(library.load(name))
    assert found.value is None
    assert found.tolerated is None
    assert "does not apply" in found.why


def colours(name: str, factors: dict[tuple[int, ...], float], epsilon: float) -> np.ndarray:
    """Colours in the end, from the closed form of the cell, of all neighbourhoods with entries times 1 + epsilon f."""
    entry = library.load(name)
    b = entry.template.B * (1 + epsilon * np.array([factors[1, i] for i in range(entry.template.B.size)]).reshape(
        entry.template.B.shape))  # fmt: skip
    z = entry.template.z * (1 + epsilon * factors[2,])
    a = entry.template.self_feedback * (1 + epsilon * factors[0,])
    count = 2 ** (b.size + 1)
    rows = 2.0 * (np.arange(count)[:, None] >> np.arange(b.size + 1) & 1) - 1
    u, other = rows[:, :-1], rows[:, -1]
    s = u @ b.ravel() + z
    if isinstance(entry.initial_state, int | float):
        x0 = np.full(count, float(entry.initial_state))
    else:
        assert isinstance(entry.initial_state, str)
        x0 = {"picture": u[:, b.size // 2], "given": other, "any": other}[entry.initial_state]
    with np.errstate(all="ignore"):
        return np.sign(np.round(output(uncoupled_state(x0, s, a, 400.0, "chua-yang")), 12))


@pytest.mark.parametrize("name", UNCOUPLED)
def test_the_tolerated_error_is_exact(name: str) -> None:
    """Just below it every corner of the box of errors leaves all cells right; just above it some corner does not."""
    entry = library.load(name)
    found = margin_of(entry).tolerated
    assert found is not None
    if found == 0:
        assert np.isclose(library.load(name).margin or 0, 0)
        return
    size = entry.template.B.size
    keys: list[tuple[int, ...]] = [(0,), (2,), *((1, i) for i in range(size))]
    right = colours(name, dict.fromkeys(keys, 0.0), 0.0)
    if entry.initial_state == "any":  # the colour of x(0) = anything is that of the drive
        assert np.array_equal(right[: len(right) // 2], right[len(right) // 2 :])
    rng = np.random.default_rng(1)
    corners = [dict.fromkeys(keys, 1.0), dict.fromkeys(keys, -1.0)]
    corners += [dict(zip(keys, rng.choice([-1.0, 1.0], len(keys)), strict=True)) for _ in range(20)]
    b, z = entry.template.B.ravel(), entry.template.z
    count = np.arange(2**size)
    u = 2.0 * (count[:, None] >> np.arange(size) & 1) - 1
    weakest = np.argsort(
        np.abs(u @ b + z + (entry.template.self_feedback - 1) * (entry.initial_state == "picture") * u[:, size // 2])
    )
    for row, push, a_error in itertools.product(u[weakest[:200]], (-1.0, 1.0), (-1.0, 1.0)):
        terms = push * np.sign(b * row)
        corners.append({(0,): a_error, (2,): push * float(np.sign(z)), **{(1, i): terms[i] for i in range(size)}})
    below = [np.array_equal(colours(name, corner, 0.999 * found), right) for corner in corners[:200]]
    assert all(below)
    assert any(not np.array_equal(colours(name, corner, 1.001 * found), right) for corner in corners)


def test_the_tolerated_error_by_hand() -> None:
    """EDGE: margin 1, sum of terms 17, and the self-feedback of 1 may err as well: 1 / 18."""
    assert margin_of(library.load("edge")).tolerated == pytest.approx(1 / 18)
    one = np.array([1.0])
    assert tolerated_error(one, np.array([0.0]), 2.0, 10.0)[0] == pytest.approx(1 / 10)
    assert tolerated_error(one, None, 0.0, 4.0)[0] == pytest.approx(1 / 4)
    assert tolerated_error(one, -one, 1.5, 4.0)[0] == pytest.approx(0.5 / 5.5)
    assert tolerated_error(one, one, 1.5, 40.0)[0] == pytest.approx(1.5 / 41.5)
    assert tolerated_error(one, one, 1.5, 4.0)[0] == pytest.approx(1.5 / 5.5)
    assert tolerated_error(one, one, 1.1, 2.0)[0] == pytest.approx(0.5)  # a falls below 1 before: s alone decides


def test_decisions_in_closed_form_are_those_of_the_cell() -> None:
    rng = np.random.default_rng(2)
    for a in (-0.5, 0.0, 0.9, 1.0, 1.3, 3.0):
        s, x0 = rng.uniform(-3, 3, 500), rng.uniform(-1, 1, 500)
        assert np.array_equal(final_colour(s, x0, a), np.sign(uncoupled_state(x0, s, a, np.inf, "chua-yang")))


def plain(template: AnyTemplate) -> Template:
    assert isinstance(template, Template)
    return template


def test_entries_of_terms_and_layers_are_disturbed_as_well() -> None:
    for name in ("median", "autowave"):
        network = library.load(name).network
        found = with_relative_errors(network, 0.1, np.random.default_rng(0))
        for before, after in zip(layered(network).layers, layered(found).layers, strict=True):
            assert len(before.terms) == len(after.terms)
            for one, two in zip(before.terms, after.terms, strict=True):
                assert np.array_equal(one.weights == 0, two.weights == 0)
                assert not np.array_equal(one.weights, two.weights)
                assert (one.of, one.table, one.layer) == (two.of, two.table, two.layer)


def test_entries_are_disturbed_as_said() -> None:
    template = Template([[0, 1, 0], [2, 3, 0], [0, 0, 0]], 4, -5)
    found = plain(with_relative_errors(template, 0.1, np.random.default_rng(0)))
    assert np.array_equal(found.A == 0, template.A == 0)
    many = [plain(with_relative_errors(template, 0.1, np.random.default_rng(seed))) for seed in range(2000)]
    assert np.std([t.z for t in many]) == pytest.approx(0.5, rel=0.1)
    assert np.std([t.A[1, 1] for t in many]) == pytest.approx(0.3, rel=0.1)
    assert np.mean([t.B[0, 0] for t in many]) == pytest.approx(4, abs=0.05)


def test_bits() -> None:
    template = Template([[1]], [[0.3, 0.0, 7.0], [0.0, -3.4, 0.0], [0.0, 0.0, 0.0]], 0.6)
    coarse = plain(quantised(template, 4))  # steps of 7 / 7
    assert coarse.B[0].tolist() == [0, 0, 7]
    assert coarse.B[1, 1] == -3
    assert coarse.z == 1
    assert np.abs(plain(quantised(template, 12)).B - template.B).max() <= 7 / 2047 / 2 + 1e-12
    assert plain(quantised(Template([[0]]), 3)).z == 0


@pytest.mark.parametrize(
    "name",
    [
        "edge",
        "horizontal-skeleton-left",
        "logic-or",
        "recall",
        "average",
        "fill-black",
        "median",
        "autowave",
        "discrete-hole-filler",
        "slow-motion",
    ],
)
def test_an_undisturbed_template_is_right(name: str) -> None:
    entry = library.load(name)
    assert error_rate_of(entry).share_of_wrong(entry.network, 0.0, np.random.default_rng(0)) == 0


def test_the_judge_counts_wrong_neighbourhoods() -> None:
    """EDGE with z = -3.5: black cells with exactly one white neighbour, 8 windows of 512, turn white."""
    entry = library.load("edge")
    wrong = Template(entry.template.A, entry.template.B, -3.5)
    assert error_rate_of(entry).share_of_wrong(wrong, 0.0, np.random.default_rng(0)) == 8 / 512


def test_the_judge_counts_wrong_cells_of_examples() -> None:
    entry = library.load("hole-filler")
    all_black = Template(entry.template.A, entry.template.B, 40.0)
    white = sum(int((example.output < 0).sum()) for example in entry.examples)
    cells = sum(example.output.size for example in entry.examples)
    assert error_rate_of(entry).share_of_wrong(all_black, 0.0, np.random.default_rng(0)) == white / cells


def test_a_grey_answer_is_compared_with_that_of_the_undisturbed_template() -> None:
    entry = library.load("median")  # its example leaves half a unit open: a median of eight is any number in a gap
    error_rate = error_rate_of(entry)
    assert error_rate.share_of_wrong(entry.network, 0.0, np.random.default_rng(0)) == 0
    template = entry.template
    neighbours, own = template.terms[0].weights, (template.A, template.B)

    def reweighted(weights: np.ndarray) -> Template:
        return Template(*own, template.z, terms=[replace(template.terms[0], weights=weights)])

    rng = np.random.default_rng(0)
    assert error_rate.share_of_wrong(reweighted(1.5 * neighbours), 0.0, rng) == 0  # equal weights: still the median
    one_decides = np.where(np.arange(9).reshape(3, 3) == 1, 0.4, 0.02) * (neighbours != 0)
    picture = entry.examples[0].input
    assert picture is not None
    above = np.vstack([picture[:1], picture[:-1]])  # 0.4 outweighs seven times 0.02: the cell above is copied
    wrong = np.abs(above - run_transient(entry.network, **entry.task(picture)).y) > 0.1
    assert error_rate.share_of_wrong(reweighted(one_decides), 0.0, rng) == wrong.mean() > 0.5


@pytest.mark.parametrize("name", ["edge", "shadow-left", "average", "autowave"])
def test_curves_can_be_reproduced_and_rise(name: str) -> None:
    entry = library.load(name)
    found, again = measure(entry, draws=6, seed=3), measure(entry, draws=6, seed=3)
    assert found == again
    assert measure(entry, draws=6, seed=4).noise != found.noise
    assert (found.entries.levels, found.bits.levels, found.noise.levels) == (SIGMAS, BITS, NOISES)
    assert found.noise.mean[-1] > found.noise.mean[0]
    assert all(0 <= m <= w <= 1 for m, w in zip(found.noise.mean, found.noise.worst, strict=True))


def test_random_errors_below_the_tolerated_one_do_nothing() -> None:
    """Normal errors of sigma stay within 5 sigma in so few draws."""
    for name in ("edge", "corner", "hole-filler", "dilation-square"):
        found = measure(library.load(name), draws=8)
        bound = found.margin.tolerated
        assert bound is not None
        assert all(w == 0 for s, w in zip(SIGMAS, found.entries.worst, strict=True) if 5 * s < bound)
        assert found.entries.largest_without_error() is not None


def test_the_command(tmp_path: Path) -> None:
    plot = tmp_path / "curve.png"
    result = CliRunner().invoke(robust, ["edge", "--draws", "3", "-o", str(plot)])
    assert result.exit_code == 0, result.output
    assert "margin 1 (exact" in " ".join(result.output.split())
    assert "5.56 %" in result.output
    with Image.open(plot) as image:
        assert image.width > 800
    data: dict[str, Any] = json.loads(CliRunner().invoke(robust, ["edge", "--draws", "3", "--json"]).output)
    assert data["margin"]["tolerated"] == pytest.approx(1 / 18)
    assert len(data["bits"]["mean"]) == len(BITS)
    assert "does not apply" in CliRunner().invoke(robust, ["average", "--draws", "1"]).output


@pytest.mark.parametrize("name", ["edge-gray", "threshold", "copy", "average"])
def test_grey_templates_are_judged_on_their_worked_pictures(name: str) -> None:
    entry = library.load(name)
    assert entry.template.uncoupled
    found = error_rate_of(entry)
    assert "worked example" in found.what
    assert "neighbourhoods" not in found.what
    assert margin_of(entry).tolerated is None


def test_a_grey_template_of_ones_own_needs_no_tag() -> None:
    """EDGEGRAY, whose worked picture is grey: black-and-white windows would know nothing of its threshold."""
    entry = library.load("edge-gray")
    own = replace(entry, name="mine", tags=(), file=None)
    assert "worked example" in error_rate_of(own).what
    assert "neighbourhoods" in error_rate_of(replace(own, examples=())).what  # what it is for is not known


def test_it_is_judged_on_pictures_that_are_given() -> None:
    """EDGE with z = -3.5 loses black cells with one white neighbour: none in a solid field, each at a missing cell."""
    entry = library.load("edge")
    wrong = Template(entry.template.A, entry.template.B, -3.5)
    field = np.ones((1, 12, 12))
    field[0, 5, 5] = -1
    assert error_rate_of(entry, 0, shown_to(entry, field)).share_of_wrong(wrong, 0.0, np.random.default_rng(0)) == (
        8 / 144  # the neighbours of the missing cell; those at the border have three white virtual ones or five
    )
    found = measure(entry, draws=2, shown=shown_to(entry, field))
    assert found.judged_on == "the 144 cells of 1 picture given"


def test_pictures_on_the_command_line(tmp_path: Path) -> None:
    rng = np.random.default_rng(0)
    (tmp_path / "shots").mkdir()
    for number in range(3):
        Image.fromarray(rng.integers(0, 256, (8, 9), np.uint8)).save(tmp_path / "shots" / f"{number}.png")
    words = ["edge-gray", "--draws", "2", "--json", "--picture", str(tmp_path / "shots")]
    data = json.loads(CliRunner().invoke(robust, words).output)
    assert data["judged_on"].startswith("the 216 cells of 3 pictures given")
    assert "frame" not in data["judged_on"]
    done = CliRunner().invoke(robust, ["recall", "--draws", "1", "--picture", str(tmp_path / "shots" / "0.png")])
    assert "takes a second picture" in str(done.exception)
    second = ["--state", str(tmp_path / "shots" / "1.png"), "--binary"]
    done = CliRunner().invoke(
        robust, ["recall", "--draws", "1", "--picture", str(tmp_path / "shots" / "0.png"), *second]
    )
    assert done.exit_code == 0, done.exception
