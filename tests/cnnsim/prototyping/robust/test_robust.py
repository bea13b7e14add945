"""Margins and tolerated errors against brute force; curves that can be reproduced."""

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
from cnnsim.prototyping.robust.disturb import quantised, with_relative_errors
from cnnsim.prototyping.robust.error_rate import error_rate_of, shown_to
from cnnsim.prototyping.robust.margin import margin_of
from cnnsim.prototyping.robust.robust import BITS, NOISES, SIGMAS, measure
from cnnsim.transient import run_transient


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


def test_a_grey_template_is_judged_as_one_on_a_white_picture_too() -> None:
    """Its answer there is white, and was compared by its sign alone."""
    entry = library.load("average")
    found = measure(entry, draws=2, shown=shown_to(entry, -np.ones((1, 5, 6))))
    assert found.judged_on.startswith("the 30 cells of 1 picture given (grey,")


def test_a_sequence_is_one_and_a_cell_is_one() -> None:
    entry = library.load("motion-right")
    found = measure(entry, draws=1, shown=shown_to(entry, -np.ones((3, 5, 6))))
    assert "cells of a sequence of 3 pictures given" in found.judged_on
    edge = library.load("edge")
    assert (
        measure(edge, draws=1, shown=shown_to(edge, np.ones((1, 1, 1)))).judged_on == "the one cell of 1 picture given"
    )


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
