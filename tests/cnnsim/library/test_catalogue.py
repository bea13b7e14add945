"""The template library: every file, every worked example on every backend."""

import re

import numpy as np
import pytest

from cnnsim import Template, library
from cnnsim.backends import NAMES as BACKENDS
from cnnsim.library.catalogue import run_example
from cnnsim.library.entry import Example
from tests.kits.library import ANSWERS
from tests.oracles.pictures import Case, black

NAMES = library.names()

LINEAR = [n for n in NAMES if isinstance(library.load(n).network, Template) and library.load(n).template.linear]

WITHOUT_ANSWER = {
    "averaging-threshold", "checkerboard", "halftone-3x3", "halftone-5x5", "halftone-5x5-crounse",
    "line-detector-3", "line-remover-7-horizontal", "line-remover-7-vertical", "patch-maker", "peel-1-pixel",
    "small-object-remover", "stripes-horizontal", "stripes-vertical", "perona-malik", "perona-malik-4", "motion-right",
    "slow-motion", "moving-parts", "herring-grid", "path-tracing", "autowave",
}  # fmt: skip
"""Templates whose task is a sentence, not a formula: `test_library_promises` and the tests of the kinds test that."""


def case_of(example: Example) -> Case:
    mask = None if example.mask is None else black(example.mask)
    return Case(example.input, example.state, mask, example.bias)


def test_the_library_is_there() -> None:
    assert len(NAMES) >= 172


def test_every_template_has_an_independent_answer_or_a_test_of_its_promise() -> None:
    assert set(ANSWERS) | WITHOUT_ANSWER == set(NAMES)
    assert not set(ANSWERS) & WITHOUT_ANSWER


def test_a_file_says_what_a_user_needs() -> None:
    for name in NAMES:
        entry = library.load(name)
        assert re.fullmatch(r"[a-z0-9]+(-[a-z0-9]+)*", name)
        assert entry.summary.endswith("."), name
        assert entry.reference, name
        assert 1 <= len(entry.examples) <= 3, name
        assert ("uncoupled" in entry.tags) is entry.network.uncoupled, name
        assert ("coupled" in entry.tags) is not entry.network.uncoupled, name
        assert all(max(example.output.shape) <= 32 for example in entry.examples), name


def test_a_small_margin_is_told() -> None:
    for name in [n for n in NAMES if (library.load(n).margin or 1) < 0.25]:
        assert "critical" in library.load(name).note.lower(), name


def test_critical_templates_have_their_margin_in_the_file() -> None:
    critical = {name for name in NAMES if library.load(name).note.startswith("Critical")}
    with_margin = {name for name in critical if library.load(name).margin is not None}
    assert {name for name in with_margin if library.load(name).margin == 0} >= {
        "edge-no-feedback", "erosion-l-shape", "dilation-l-shape", "erosion-cross", "dilation-cross",
        "figure-reconstructor", "horizontal-line-detector",
    }  # fmt: skip


def test_the_margin_of_a_coupled_template() -> None:
    """The smallest drive over all black and white neighbourhoods, y of the cell itself weighing a - 1."""
    for entry in (library.load(name) for name in LINEAR):
        template = entry.template
        if template.uncoupled or entry.margin is None:
            continue
        others = [tap.weight for tap in template.feedback_taps if (tap.k, tap.l) != (0, 0)]
        weights = [template.self_feedback - 1, *others, *(tap.weight for tap in template.control_taps)]
        drives = np.array([template.z])
        for weight in weights:
            drives = np.unique(np.round(np.concatenate([drives - weight, drives + weight]), 9))
        assert entry.margin == pytest.approx(np.abs(drives).min(), abs=1e-9), entry.name


ISOTROPIC = [
    "averaging-threshold", "checkerboard", "concave-filler", "connectivity", "diffusion", "edge-gray",
    "figure-reconstructor", "framed-areas", "halftone-3x3", "halftone-5x5", "halftone-5x5-crounse",
    "hole-filler", "inverse-halftone-3x3", "inverse-halftone-5x5", "laplace-solver", "line-detector-3",
    "muller-lyer", "patch-maker", "peel-1-pixel", "poisson-solver", "recall", "small-object-remover",
    "surface-interpolation", "trigger-wave", "trigger-wave-white",
]  # fmt: skip


def test_templates_that_know_no_direction() -> None:
    for template in (library.load(name).template for name in ISOTROPIC):
        for matrix in (template.A, template.B):
            assert np.array_equal(matrix, np.rot90(matrix)), template
            assert np.array_equal(matrix, matrix.T), template


def test_templates_made_from_one_another() -> None:
    a = {name: library.load(name).template.A for name in LINEAR}
    b = {name: library.load(name).template.B for name in LINEAR}
    assert np.array_equal(a["stripes-horizontal"], a["stripes-vertical"].T)
    assert np.array_equal(a["line-remover-7-horizontal"], a["line-remover-7-vertical"].T)
    assert np.array_equal(b["line-remover-7-horizontal"], b["line-remover-7-vertical"].T)
    assert np.array_equal(a["trigger-wave-white"], a["trigger-wave"])
    assert np.allclose(b["inverse-halftone-5x5"], b["halftone-5x5"] / 5, atol=1e-12)
    for name in ("halftone-3x3", "halftone-5x5"):
        ring = a[name] + b[name]
        ring[ring.shape[0] // 2, ring.shape[0] // 2] = 0
        assert not ring.any(), "neighbours pull with B what they push with A"
    for quarters, name in enumerate(("shadow-left", "shadow-up", "shadow-right", "shadow-down")):
        assert np.array_equal(a[name], np.rot90(a["shadow-left"], -quarters))


@pytest.mark.parametrize("backend", BACKENDS)
@pytest.mark.parametrize("name", NAMES)
def test_the_examples_hold(name: str, backend: str) -> None:
    entry = library.load(name)
    for example in entry.examples:
        result = run_example(entry, example, backend=backend)
        assert example.holds(result.y), np.round(result.y, 3)


def test_an_example_is_what_the_definition_says() -> None:
    for name in ANSWERS:
        for example in library.load(name).examples:
            answer = ANSWERS[name](case_of(example))
            assert np.abs(example.output - answer).max() <= (0 if example.tolerance is None else 1e-4), name
