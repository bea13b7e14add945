"""The command `accuracy`: a table that fits a terminal, files that are whole, mistakes in a line."""

import csv
from pathlib import Path

import pytest
from click.testing import CliRunner, Result

from cnnsim.cli.accuracy import table
from cnnsim.cli.group import main
from cnnsim.prototyping.accuracy.work_precision import PrecisionRow


def called(*words: str) -> Result:
    return CliRunner().invoke(main, ["accuracy", *words])


def test_the_table_fits_a_terminal_and_the_file_has_a_row_a_run(tmp_path: Path) -> None:
    found = called("threshold", "--time", "1", "--csv", str(tmp_path / "a.csv"), "-o", str(tmp_path / "a.png"))
    assert found.exit_code == 0, found.output
    head, *lines = found.stdout.splitlines()[-9:]
    assert head.split() == ["error", "cheapest", "setting", "A*y", "time", "times", "signs"]
    assert [line.split()[0] for line in lines] == [f"1e-{digits}" for digits in range(1, 9)]
    assert max(map(len, [head, *lines])) <= 80
    with (tmp_path / "a.csv").open(encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    assert {row["dtype"] for row in rows} == {"float32", "float64"}
    euler = [float(row["error"]) for row in rows if row["scheme"] == "euler" and row["dtype"] == "float64"]
    assert euler[0] > 30 * euler[-1] > 0  # a step of a 128th: first order
    assert (tmp_path / "a.png").read_bytes().startswith(b"\x89PNG")


def test_the_longest_names_fit_a_terminal() -> None:
    row = PrecisionRow("opencl", "float64", "exponential-euler", 0.3333333, 1e-9, 0.98765, 99999, 0.123456)
    lines = table([row])
    assert len(lines) == 9
    assert max(map(len, lines)) <= 80


@pytest.mark.parametrize("option", ["--csv", "-o"])
def test_a_folder_in_the_place_of_a_file_is_refused(option: str, tmp_path: Path) -> None:
    (tmp_path / "out.png").mkdir()
    found = called("threshold", "--time", "1", option, str(tmp_path / "out.png"))
    assert found.exit_code == 2
    assert "there is a folder of that name" in found.output
    assert not list((tmp_path / "out.png").iterdir())


def test_a_template_without_one_layer_in_continuous_time_is_refused() -> None:
    found = called("life-discrete")
    assert found.exit_code == 2
    assert "discrete time" in found.output
