"""Steps of programs that run to an accuracy, in memories that may keep less of it."""

import warnings
from pathlib import Path

import numpy as np
import pytest

from cnnsim import load_program, run, run_program

STEP = """
name = "p"
lam = ["a", "b"]
inputs = ["a"]
outputs = ["b"]
step = [{ template = "diffusion", state = "a", to = "b", duration = 2.0, accuracy = ACCURACY }]
"""


@pytest.mark.parametrize(("accuracy", "kept_to"), [(2.5e-9, 6e-8), (1e-5, 1e-5)])
def test_memories_that_keep_less_than_the_accuracy_are_told(tmp_path: Path, accuracy: float, kept_to: float) -> None:
    """Of float32: half a last digit of 1 is 6e-8."""
    (tmp_path / "p.toml").write_text(STEP.replace("ACCURACY", str(accuracy)))
    program = load_program(tmp_path / "p.toml")
    picture = np.random.default_rng(0).uniform(-1, 1, (8, 9))
    truth = run("diffusion", picture, duration=2.0, accuracy="exact").y
    with warnings.catch_warnings(record=True) as said:
        warnings.simplefilter("always")
        kept = run_program(program, a=picture)["b"]
        finely = run_program(program, a=picture, dtype="float64")["b"]
    words = [str(one.message) for one in said]
    assert bool(words) is (kept_to > accuracy)
    assert all("rounded by up to 6e-08" in one for one in words)
    assert np.abs(kept - truth).max() <= kept_to
    assert np.abs(finely - truth).max() <= accuracy
