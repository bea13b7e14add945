"""Prototyping from Python: design, robust, trace and accuracy take names, templates, entries and designs."""

from dataclasses import replace

import numpy as np
import pytest

import cnnsim
from cnnsim import InputError, Template, library
from cnnsim.prototyping.functions import Subject, entry_of

PICTURE = np.where(np.random.default_rng(0).random((9, 11)) < 0.4, 1.0, -1.0)
EDGE = Template([[0, 0, 0], [0, 1, 0], [0, 0, 0]], [[-1, -1, -1], [-1, 8, -1], [-1, -1, -1]], -1)


def test_a_designed_template_does_what_the_rule_says() -> None:
    found = cnnsim.design("c and not n")
    north = np.vstack([np.full((1, 11), -1.0), PICTURE[:-1]])
    assert found.one_template
    assert np.array_equal(cnnsim.run(entry_of(found), PICTURE).y > 0, (PICTURE > 0) & (north <= 0))


def test_a_design_from_a_pair_of_pictures() -> None:
    wide = np.where(np.random.default_rng(1).random((40, 40)) < 0.5, 1.0, -1.0)
    found = cnnsim.design([(wide, cnnsim.run("edge", wide).y)])
    assert np.array_equal(cnnsim.run(entry_of(found), PICTURE).y, cnnsim.run("edge", PICTURE).y)


@pytest.mark.parametrize("subject", ["edge", EDGE, library.load("edge")], ids=["name", "template", "entry"])
def test_what_a_name_a_template_and_an_entry_give(subject: Subject) -> None:
    found = cnnsim.robust(subject, draws=2)
    assert found.margin.value == 1
    assert found.bits_needed() is not None
    trace = cnnsim.trace(subject, PICTURE, frames=4)
    assert trace.x.shape == (5, 9, 11)


def test_robustness_is_judged_on_given_pictures() -> None:
    assert "1 picture" in cnnsim.robust("hole-filler", PICTURE, draws=1).judged_on
    assert "2 pictures" in cnnsim.robust("hole-filler", [PICTURE, -PICTURE], draws=1).judged_on


def test_accuracy_falls_with_the_step() -> None:
    found = cnnsim.accuracy("diffusion", PICTURE)
    assert found._repr_html_().count("<tr>") == len(found.rows) + 1
    errors = {row["step"]: row["error"] for row in found.table() if (row["scheme"], row["dtype"]) == ("rk4", "float64")}
    steps = sorted(errors)
    assert len(steps) >= 4
    assert errors[steps[0]] < errors[steps[-1]] / 100
    assert found.plot().get_xscale() == "log"


def test_subjects_that_do_not_fit_are_named() -> None:
    with pytest.raises(InputError, match="a design of 2 templates"):
        cnnsim.robust(cnnsim.design("c xor n"))
    moving = next(name for name in library.names() if library.load(name).frame_time)
    with pytest.raises(InputError, match="takes a sequence"):
        cnnsim.accuracy(moving, PICTURE)
    with pytest.raises(InputError, match="no-such-template"):
        cnnsim.trace("no-such-template", PICTURE)
    assert entry_of(replace(library.load("edge"), note="mine")).note == "mine"
