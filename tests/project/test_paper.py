"""Figures of the paper: verdicts and numbers of all claims."""

import importlib
import json
import re
import subprocess
import sys
from collections.abc import Callable
from functools import cache
from pathlib import Path
from types import ModuleType

import numpy as np
import pytest
from PIL import Image

from examples.paper import __main__ as every
from examples.paper import ablation, calibration_gains
from examples.paper.claims import Claim, table
from examples.paper.skins import ALL, POINT, SKINS, STRESS, on_the_bench
from tests.kits.paths import ROOT

VERDICTS = {
    "fig03_region_of_interest": [True, True, True],
    "fig05_centre_line": [True, True, True, True],
    "fig06_normal_to_shear_ratio": [True, True, True, True],
    # a taxel of 300 um averages more than theirs, and a bonded bottom has no strain across it
    "fig07_parallel_lines": [True, True, False, False, True, True, True, True],
    "fig08_speed": [True, True, False, True, False, True, True],  # the same
    "fig14_responses": [True, True, True, False],  # read raw, the ratio is a part of the friction and follows the force
    "fig15_classification": [True, True, False],  # simulated pulls scatter less
}
NUMBERS = {
    ("fig03_region_of_interest", 0): (1.414214,),
    ("fig03_region_of_interest", 2): (2.0, 0.25),
    ("fig05_centre_line", 1): (2.3292,),
    ("fig05_centre_line", 2): (1.461, 0.005),
    ("fig05_centre_line", 3): (1, 2, 1.164, 1.5),
    ("fig06_normal_to_shear_ratio", 1): (0.760, 50, 0.960, 250),
    ("fig06_normal_to_shear_ratio", 2): (1.447, 50, 1.042, 250),
    ("fig07_parallel_lines", 0): (2.1,),
    ("fig07_parallel_lines", 1): (12.6, 3.6),
    ("fig07_parallel_lines", 2): (46, 6),
    ("fig07_parallel_lines", 3): (10.3, 2.8, 3.6, 2.7, 2.3),
    ("fig07_parallel_lines", 4): (3.1, 9.2, 8.6, 6.6, 5.8),
    ("fig08_speed", 0): (0.5,),
    ("fig08_speed", 1): (0.444,),
    ("fig08_speed", 2): (0.475, 0.467, 0.445, 0.450, 0.456),
    ("fig08_speed", 3): (0.451, 0.391, 0.392, 0.401, 0.407),
    ("fig08_speed", 4): (0.288,),  # with tip and layer
    ("fig08_speed", 5): (0.435,),
    ("fig08_speed", 6): (1.127, 0.5, 150, 12.6, 3.6),
    ("fig14_responses", 3): (0.64, 0.74),
    ("fig15_classification", 0): (1.92,),
    ("fig15_classification", 1): (100.0,),
}
"""Numbers in the claims: from theory, the paper's formulas, or measured with one realisation of the noise. In 20 other
realisations errors of places are 6.9 to 11.8 um under a cover of 1 z (strain), and within 20 % of these elsewhere."""


@cache
def claims(name: str) -> list[Claim]:
    compare: Callable[[Path | None], list[Claim]] = importlib.import_module(f"examples.paper.{name}").compare
    return compare(None)


@pytest.mark.parametrize("name", VERDICTS)
def test_verdicts(name: str) -> None:
    made = claims(name)
    assert [claim.agrees for claim in made] == VERDICTS[name], made
    assert all(claim.figure == str(int(name[3:5])) for claim in made)
    assert all(claim.why for claim in made if not claim.agrees)  # a difference has a reason


@pytest.mark.parametrize(("name", "index"), NUMBERS)
def test_numbers(name: str, index: int) -> None:
    numbers = [float(number) for number in re.findall(r"\d+(?:\.\d+)?", claims(name)[index].ours)]
    wanted = NUMBERS[name, index]
    assert numbers[: len(wanted)] == pytest.approx(wanted, rel=0.02)


def test_every_script_is_found_and_tested() -> None:
    mine = [name for name in every.SCRIPTS if name in VERDICTS]
    assert mine == sorted(VERDICTS)


@pytest.mark.parametrize("name", VERDICTS)
def test_pictures(name: str, tmp_path: Path) -> None:
    importlib.import_module(f"examples.paper.{name}").compare(tmp_path)
    (drawn,) = tmp_path.glob("*.png")
    assert drawn.stem.startswith(name[:5])
    with Image.open(drawn) as picture:
        grey = np.asarray(picture.convert("L"))
    assert grey.min() < 64
    assert grey.max() > 192


def test_one_figure_alone(tmp_path: Path) -> None:
    command = [sys.executable, "-m", "examples.paper", "3", "--json", "-o", str(tmp_path / "new")]
    done = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=True)
    printed = json.loads(done.stdout)
    assert [Claim(**claim) for claim in printed] == claims("fig03_region_of_interest")
    assert (tmp_path / "new" / "fig03.png").is_file()


def test_all_scripts_in_one_table(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(every, "SCRIPTS", ["fig03_region_of_interest", "fig06_normal_to_shear_ratio"])
    monkeypatch.setattr(sys, "argv", ["paper", "--json", "-o", str(tmp_path)])
    every.main()
    printed = [Claim(**claim) for claim in json.loads(capsys.readouterr().out)]
    assert printed == claims("fig03_region_of_interest") + claims("fig06_normal_to_shear_ratio")
    assert sorted(path.name for path in tmp_path.iterdir()) == ["fig03.png", "fig06.png"]
    monkeypatch.setattr(sys, "argv", ["paper"])
    every.main()
    shown = capsys.readouterr().out
    assert shown.count("agrees") == len(printed)


@pytest.mark.parametrize("study", [ablation, calibration_gains])
def test_studies_print_and_draw(
    study: ModuleType, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(sys, "argv", ["study", "-o", str(tmp_path)])
    monkeypatch.setattr(study, "SKINS", (POINT, STRESS))
    study.main()
    shown = capsys.readouterr().out
    assert POINT.name in shown
    assert STRESS.name in shown
    assert len(list(tmp_path.glob("*.png"))) == 1
    monkeypatch.setattr(sys, "argv", ["study", "--json"])
    study.main()
    assert {line["skin"] for line in json.loads(capsys.readouterr().out)} == {POINT.name, STRESS.name}


def test_the_table_contains_all_fields(capsys: pytest.CaptureFixture[str]) -> None:
    table([Claim("7", "what [it] is", "3-5 um", "60 um", False, "because"), Claim("8", "speed", "1", "1", True)])
    shown = capsys.readouterr().out
    for word in ("what [it] is", "3-5 um", "60 um", "not so", "because", "agrees"):
        assert word in shown


def test_findings_reproduced_by_each_error() -> None:
    found = {skin.name: set(ablation.line(skin, on_the_bench(skin))["brings_back"]) for skin in SKINS}
    for name in (
        "ideal", "needle vibration", "surface waviness", "poisson ratio", "motor noise", "read noise", "all noise",
    ):  # fmt: skip
        assert not found[name], name
    for name in ("finite tip", "taxel area", "strain nonlinearity", "finite thickness", "taxel 100 um wide"):
        assert {"slow", "bent"} <= found[name], name
    assert "beta_ns > 1" in found["finite thickness"]
    assert not found["finite tip"] & {"beta_ns > 1"}
    assert found[STRESS.name] == {"beta_ns > 1", "slow", "3-5 um"}
    assert found[POINT.name] == {"beta_ns > 1", "slow", "bent", "3-5 um"}  # all of the paper's findings at once
    assert found[ALL.name] == {"beta_ns > 1", "slow", "bent"}


def test_a_taxel_that_measures_stress_has_beta_three_halves() -> None:
    # sigma: 1 over (1/2) / (5/4)^(5/2); strain: 2 over (3/2) / (5/4)^(5/2): their ratio is 3/2
    trial = on_the_bench(STRESS)
    assert trial.beta == pytest.approx(1.5, rel=1e-9)
    r = trial.made.places[5, :, 0] / 200e-6
    bent = np.divide(np.sqrt(1 + 2 * r * r) - 1, r, out=np.zeros_like(r), where=np.abs(r) > 1e-9)
    assert trial.located.places[5, :, 0] / 200e-6 == pytest.approx(bent, abs=1e-9)


def test_every_calibration_reduces_its_error() -> None:
    found = {
        skin.name: {gain.step: gain for gain in calibration_gains.calibrated(skin)} for skin in calibration_gains.SKINS
    }
    ideal = found["ideal"]
    assert ideal["beta_ns"].near < 1e-6
    assert ideal["beta_ns"].force == pytest.approx(0.2, rel=1e-6)  # 0.8 of the nominal gain
    assert ideal["load"].force < 1e-9
    assert ideal["radial"].far < 1e-6
    single = "finite tip", "finite thickness", "taxel area", "strain nonlinearity", STRESS.name, POINT.name
    for name in (*single, ALL.name):
        steps = found[name]
        assert steps["beta_ns"].near < steps["nominal"].near, name
        assert steps["thickness"].near < 0.65 * steps["beta_ns"].near, name
        # with all at once the square area, tip and layer leave 3 to 7 um that go as cos(4 phi): no radius corrects
        assert steps["radial"].far < (0.62 if name == ALL.name else 0.45) * steps["load"].far, name
        assert steps["radial"].force < 0.6 * steps["nominal"].force, name
        assert not steps["radial"].lost_inside, name
        # a square taxel locates loads near the axes 3 to 7 um farther out than the ring's mean: of 332 answers with
        # all effects, those on the line at 227 um may lie beyond the last ring (275 of 33 200 in 100 realisations)
        assert steps["radial"].lost == (name == ALL.name), name
    for step in ("thickness", "load", "radial"):  # calibration does not change noise
        assert found["noise"][step].near == pytest.approx(found["noise"]["beta_ns"].near, rel=0.1)
    assert 3 < found[POINT.name]["radial"].far < 5  # the paper's precision, but up to 230 um
