"""The number of threads is checked, and changes the time alone."""

import os
import subprocess
import sys
from pathlib import Path
from typing import Any

import numba
import numpy as np
import pytest
from click.testing import CliRunner

from cnnsim import (
    PERIODIC,
    InputError,
    LayeredTemplate,
    Template,
    Term,
    UniversalMachine,
    load_program,
    run,
    run_transient,
    write_picture,
)
from cnnsim.backends import get
from cnnsim.cli.group import main

PICTURE = np.where(np.random.default_rng(0).random((90, 120)) > 0.5, 1.0, -1.0)
ALL = int(numba.config.NUMBA_NUM_THREADS)


@pytest.mark.parametrize("name", ["hole-filler", "median"])
def test_the_result_is_the_same_on_any_number_of_threads(name: str) -> None:
    changes: Any = {} if name == "hole-filler" else {"duration": 1.0}
    one, all_of_them = (run(name, PICTURE, threads=count, **changes) for count in (1, ALL))
    assert np.array_equal(one.x, all_of_them.x)
    assert one.t == all_of_them.t


def test_layers_and_delays_are_the_same_on_any_number_of_threads() -> None:
    ring = np.array([[0.1, 0, 0.2], [0, 0, 0], [0.3, 0, -0.1]])
    layers = LayeredTemplate(
        [Template(1.5, terms=[Term(ring, "x_kl - x_ij", layer=other), Term(ring, delay=0.2)]) for other in (1, 0)]
    )
    state = np.random.default_rng(0).uniform(-1, 1, (3, 2, 33, 70))
    one, ends = (
        run_transient(layers, state=state, duration=1.0, boundary=PERIODIC, backend=get("cpu", threads=count)).x
        for count in (1, ALL)
    )
    assert np.array_equal(one, ends)
    like = run_transient(layers, state=state, duration=1.0, boundary=PERIODIC, backend="reference").x
    assert np.allclose(ends, like, atol=1e-5)


@pytest.mark.parametrize("wrong", [0, -1, True, 1.5, "2", 10_000])
def test_a_number_that_cannot_be(wrong: Any) -> None:
    with pytest.raises(InputError, match=f"threads .*; a whole number from 1 to {ALL}, the number of cores, wanted"):
        get("cpu", threads=wrong)


def test_other_backends_have_no_choice() -> None:
    with pytest.raises(InputError, match="only the cpu backend takes threads"):
        run("edge", PICTURE, backend="reference", threads=1)


def test_programs_and_command_lines_take_it_too(tmp_path: Path) -> None:
    opened = UniversalMachine(threads=1).run(load_program("opening"), picture=PICTURE)["opened"]
    assert np.array_equal(opened, UniversalMachine().run(load_program("opening"), picture=PICTURE)["opened"])
    write_picture(PICTURE, tmp_path / "in.png")
    place = str(tmp_path / "in.png")
    for texts in (["run", "edge", place], ["program", "opening", "--input", f"picture={place}"]):
        plain, one = (CliRunner().invoke(main, [*texts, *more]) for more in ([], ["--threads", "1"]))
        assert plain.exit_code == one.exit_code == 0
        assert plain.output == one.output
        many = CliRunner().invoke(main, [*texts, "--threads", "10000"])
        assert many.exit_code == 2
        assert "the number of cores" in many.output


def test_waiting_threads_sleep() -> None:
    """OpenMP prints what it has read when the first loop starts its threads."""
    code = (
        "import numpy as np; from cnnsim.backends.cpu.planes import clip; x = np.zeros((1, 9, 9)); clip.threaded(x, x)"
    )
    where = {key: value for key, value in os.environ.items() if key != "OMP_WAIT_POLICY"} | {"OMP_DISPLAY_ENV": "true"}
    ran = subprocess.run([sys.executable, "-c", code], env=where, capture_output=True, text=True, check=True)
    if "OPENMP DISPLAY" not in ran.stderr:
        pytest.skip("numba's threads are not those of OpenMP")
    assert "OMP_WAIT_POLICY = 'PASSIVE'" in ran.stderr
