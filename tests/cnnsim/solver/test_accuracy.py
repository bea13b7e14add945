"""An accuracy that is asked for is kept, its estimate is near the true error, and undecided cells are named."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from click.testing import CliRunner

from cnnsim import InputError, Template, Term, explain, fixed, library, load_program, run, run_program, run_transient
from cnnsim.backends import NAMES
from cnnsim.cli.group import main
from cnnsim.library.write import template_text
from tests.benchmarks.accuracy.random_cases import case
from tests.kits.backends import build

SEEDS = range(70_000, 70_008)
HELD = [[0, 0.4, 0], [0.3, 1.6, -0.5], [0, 0.4, 0]]


@pytest.mark.parametrize("accuracy", [1e-1, 1e-2, 1e-3, 1e-4, 1e-6, 1e-8])
def test_it_is_kept_and_the_estimate_is_no_less_than_the_error(accuracy: float) -> None:
    for seed in SEEDS:
        one = case(seed)
        found = run_transient(**one.given, accuracy=accuracy)
        error = float(np.abs(found.x - one.exact).max())
        assert error <= accuracy, (seed, error, found.how)
        assert error <= found.error <= accuracy, (seed, error, found.how)


@pytest.mark.parametrize("name", NAMES)
def test_every_backend_keeps_it(name: str) -> None:
    build(name, None, "float64")
    one = case(3)
    for accuracy in (1e-2, 1e-5):
        found = run_transient(**one.given, accuracy=accuracy, backend=name)
        assert np.abs(found.x - one.exact).max() <= accuracy


def test_float32_that_cannot_give_it_is_left_and_that_is_said() -> None:
    one = case(11)
    found = run_transient(**one.given, accuracy=1e-6, dtype="float32")
    assert found.x.dtype == np.float64
    assert "float32 cannot give 1e-06" in found.how
    assert run_transient(**one.given, accuracy=1e-2, dtype="float32").x.dtype == np.float32


def test_exact_is_within_1e_10() -> None:
    one = case(14)
    assert np.abs(run_transient(**one.given, accuracy="exact").x - one.exact).max() < 1e-10


def test_signs_that_the_runs_do_not_agree_on_are_named() -> None:
    for seed in SEEDS:
        one = case(seed)
        found = run_transient(**one.given, accuracy="binary")
        wrong = {tuple(cell) for cell in np.argwhere(np.sign(found.y) != np.sign(one.exact))}
        assert wrong <= {tuple(cell) for cell in found.undecided}
    unstable, x = Template([[0, 0.3, 0], [0.3, 2, 0.3], [0, 0.3, 0]]), np.zeros((3, 4))
    lone = run_transient(unstable, state=x, duration=3.0, accuracy="binary", boundary=fixed(0))
    assert len(lone.undecided) == x.size


def test_settled_templates_end_where_shorter_steps_do() -> None:
    picture = np.where(np.random.default_rng(2).random((20, 20)) < 0.5, 1.0, -1.0)
    for accuracy in ("binary", 1e-3):
        found = run("hole-filler", picture, accuracy=accuracy)
        assert np.array_equal(found.y > 0, run("hole-filler", picture, scheme="rk4", step=0.05).y > 0)
        assert not len(found.undecided)
    fine = run("laplace-solver", picture * 0.5, mask=picture, accuracy=1e-7)
    assert fine.error <= 1e-7
    assert "accuracy 1e-07" in fine.how


@pytest.mark.parametrize("shape", [(8, 8), (2, 8, 8)])
def test_what_is_explained_is_what_is_run(shape: tuple[int, ...]) -> None:
    wave = Template([[0.1, 0.3, 0.1], [0.2, 1.5, 0.2], [0.1, 0.4, 0.1]], 0.4, 0.05)
    x = np.random.default_rng(2).uniform(-1, 1, shape)
    found = run_transient(wave, state=x, input=x, duration=2.0, accuracy=0.1)
    said = str(explain(wave, x, duration=2.0, accuracy=0.1))
    assert "accuracy 0.1" in said
    assert ("corrected kinks" in found.how) == ("corrected kinks" in said) == (len(shape) == 2)


@pytest.mark.parametrize("wrong", [0, -1, 2, "fine", 1e-15, True, float("nan")])
def test_accuracies_that_are_none_are_refused(wrong: Any) -> None:
    with pytest.raises(InputError, match="accuracy"):
        run_transient(Template(0.5), state=np.zeros((2, 2)), accuracy=wrong)


def test_scheme_and_accuracy_exclude_each_other() -> None:
    with pytest.raises(InputError, match="one or the other"):
        run_transient(Template(0.5), state=np.zeros((2, 2)), accuracy=1e-3, scheme="rk4")


def test_files_and_programs_say_an_accuracy(tmp_path: Path) -> None:
    (tmp_path / "blur.toml").write_text(
        'name = "blur"\nsummary = "x"\nreference = "x"\nA = [[0, 0.2, 0], [0.2, 0, 0.2], [0, 0.2, 0]]\nz = 0\n'
        'input = "none"\ninitial_state = "picture"\nboundary = "zero-flux"\nduration = 3\naccuracy = 1e-6\n'
    )
    entry = library.load_file(tmp_path / "blur.toml")
    picture = np.random.default_rng(4).uniform(-1, 1, (6, 7))
    found = run(entry, picture)
    assert found.error <= 1e-6
    assert np.isnan(run(entry, picture, step=0.1).error)
    assert "accuracy = 1e-06" in template_text(entry)
    (tmp_path / "soft.toml").write_text(
        'name = "soft"\nlam = ["picture", "soft"]\ninputs = ["picture"]\noutputs = ["soft"]\n'
        '[[step]]\ntemplate = "blur"\nstate = "picture"\nto = "soft"\naccuracy = 1e-9\n'
    )
    with library.using(tmp_path):
        soft = run_program(tmp_path / "soft.toml", picture=picture, dtype="float64")["soft"]
    exact = run(entry, picture, accuracy="exact").y
    assert np.abs(soft - exact).max() <= 1e-9
    (tmp_path / "soft.toml").write_text((tmp_path / "soft.toml").read_text().replace("1e-9", '"good"'))
    with library.using(tmp_path), pytest.raises(InputError, match="accuracy 'good'"):
        load_program(tmp_path / "soft.toml")


def test_the_command_shows_what_accuracy_costs(tmp_path: Path) -> None:
    found = CliRunner().invoke(
        main, ["accuracy", "diffusion", "--csv", str(tmp_path / "a.csv"), "-o", str(tmp_path / "a.png")]
    )
    assert found.exit_code == 0, found.output
    assert "exact state: solved to 1e-10" in found.output
    assert len((tmp_path / "a.csv").read_text().splitlines()) > 30
    assert (tmp_path / "a.png").stat().st_size > 10_000
    run_it = CliRunner().invoke(main, ["explain", "diffusion", "--accuracy", "1e-6", "--size", "8x8"])
    assert "accuracy 1e-06" in run_it.output


@pytest.mark.parametrize("accuracy", [1e-2, "binary"])
@pytest.mark.parametrize("terms", [(), (Term(0.1, "x_kl"),)], ids=["linear", "with a term"])
@pytest.mark.parametrize("shape", [(9, 11), (2, 9, 11)], ids=str)
def test_held_cells_keep_their_state_to_the_bit(shape: tuple[int, ...], terms: Any, accuracy: Any) -> None:
    rng = np.random.default_rng(4)
    state, mask = rng.uniform(-1, 1, shape).astype(np.float32), rng.random(shape) < 0.3
    state[mask & (rng.random(shape) < 0.5)] = 0  # which has no sign, and is to get none
    template = Template([[0, 0.4, 0], [0.3, 1.6, -0.5], [0, 0.4, 0]], 0.0, 0.1, terms=terms)
    found = run_transient(template, state=state, mask=mask, duration=2.0, accuracy=accuracy)
    assert np.array_equal(found.x[mask].astype(np.float32), state[mask])
    assert not np.array_equal(found.x[~mask], state[~mask])


@pytest.mark.parametrize("accuracy", [None, 1e-2, "binary"])
@pytest.mark.parametrize(
    ("template", "more"),
    [
        (Template(HELD, 0.0, 0.1), {"duration": 2.0}),
        (Template(HELD, 0.0, 0.1), {"duration": 2.0, "cell": "full-range"}),
        (Template(HELD, 0.0, 0.1, terms=[Term([[0.1]], "y_kl", delay=0.5)]), {"duration": 2.0}),
        (Template([[0, 0.25, 0], [0.25, 0, 0.25], [0, 0.25, 0]], 0.0, 0.1), {}),
        (Template(2.0, 0.0, 0.1), {}),
        (Template(2.0, 0.0, 0.1), {"duration": 2.0}),
    ],
    ids=["steps", "full-range", "delay", "rest", "closed form at rest", "closed form"],
)
def test_nothing_decides_about_held_cells(template: Template, more: Any, accuracy: Any) -> None:
    """Their state stays as it is, so that 0, and what is next to 0, is in no doubt: both runs are the same."""
    rng = np.random.default_rng(4)
    state, mask = rng.uniform(-1, 1, (11, 12)), rng.random((11, 12)) < 0.3
    for held in (0.0, 1e-9, 0.5):
        found = run_transient(template, state=np.where(mask, held, state), mask=mask, accuracy=accuracy, **more)
        assert not mask[tuple(found.undecided.T)].any(), found.how


@pytest.mark.filterwarnings("ignore:overflow encountered")
@pytest.mark.parametrize("accuracy", [None, 1e-3, "binary"])
def test_what_float32_cannot_hold_is_refused_by_any_way(accuracy: Any) -> None:
    state = np.random.default_rng(0).uniform(-1, 1, (6, 7))
    given: dict[str, Any] = {"state": state, "bias": np.full((6, 7), 1e39), "duration": 2.0, "accuracy": accuracy}
    with pytest.raises(InputError, match="planes must hold finite numbers"):
        run_transient(Template(HELD), **given)
    assert np.isfinite(run_transient(Template(HELD), **given, dtype="float64").x).all()
