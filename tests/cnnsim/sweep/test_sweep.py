from pathlib import Path

import numpy as np
import pytest

import cnnsim
from cnnsim.support import InputError
from cnnsim.sweep import transients
from cnnsim.sweep.plot import draw_columns, parse_plot
from cnnsim.sweep.run import SweepSummary, run_sweep
from cnnsim.sweep.spec import read_sweep
from cnnsim.sweep.table import SweepTable

KINDS = {"made-up": "tests.cnnsim.sweep.made_up"}


def swept(tmp_path: Path, text: str, workers: int = 1) -> SweepSummary:
    tmp_path.mkdir(exist_ok=True)
    (tmp_path / "spec.toml").write_text(f'kind = "made-up"\n{text}')
    return run_sweep(read_sweep(tmp_path / "spec.toml", KINDS), tmp_path / "out", workers=workers)


def test_every_combination_is_a_case_and_has_its_row_the_last_key_changing_fastest(tmp_path: Path) -> None:
    found = swept(tmp_path, '[grid]\nm = ["a", "b"]\nn = { from = 3, count = 3 }\n')
    assert [(row["case"], row["m"], row["n"], row["square"]) for row in found.rows] == [
        (0, "a", 3, 9), (1, "a", 4, 16), (2, "a", 5, 25), (3, "b", 3, 9), (4, "b", 4, 16), (5, "b", 5, 25),
    ]  # fmt: skip
    assert found.failed == 0
    assert found.run == 6
    assert {row["together"] for row in found.rows} == {1}  # a quarter of a group of 3
    assert {row["together"] for row in swept(tmp_path / "b", "[grid]\nn = { from = 0, count = 80 }\n").rows} == {20}


def test_a_range_may_be_even_or_logarithmic(tmp_path: Path) -> None:
    (tmp_path / "a.toml").write_text(
        'kind = "made-up"\n[grid]\nn = [1]\nm = { from = 1, to = 100, count = 3, spacing = "log" }\n'
        "fails = { from = 0.0, to = 1.0, count = 3 }"
    )
    sweep = read_sweep(tmp_path / "a.toml", KINDS)
    assert sweep.grid["m"] == (1.0, 10.0, 100.0)
    assert sweep.grid["fails"] == (0.0, 0.5, 1.0)


def test_a_case_that_fails_is_a_row_with_its_error(tmp_path: Path) -> None:
    found = swept(tmp_path, "[grid]\nn = { from = 0, count = 40 }\n[fixed]\nfails = [7, 23]\n")
    assert found.failed == 2
    assert found.rows[7]["error"] == "InputError: 7 is bad; another wanted"
    assert [row["square"] for row in found.rows if row["error"] is None] == [
        n * n for n in range(40) if n not in (7, 23)
    ]


def test_a_case_that_kills_its_process_is_a_row_with_its_error(tmp_path: Path) -> None:
    found = swept(tmp_path, "[grid]\nn = { from = 0, count = 6 }\n[fixed]\nkills = [4]\n", workers=2)
    assert [row["case"] for row in found.rows if row["error"]] == [4]
    assert found.rows[4]["error"] == "its process died"
    assert [row["square"] for row in found.rows if not row["error"]] == [n * n for n in range(6) if n != 4]


def test_a_stopped_sweep_runs_the_cases_without_a_row(tmp_path: Path) -> None:
    log = tmp_path / "log"
    (tmp_path / "spec.toml").write_text(
        f'kind = "made-up"\n[grid]\nn = {{ from = 0, count = 9 }}\n[fixed]\nlog = "{log}"\n'
    )
    sweep = read_sweep(tmp_path / "spec.toml", KINDS)
    table = SweepTable(tmp_path / "out", sweep.digest)
    table.add([{"case": k, "n": k, "square": k * k} for k in (0, 1, 2, 5)])
    table.write()
    found = run_sweep(sweep, tmp_path / "out", workers=1)
    assert found.run == 5
    assert sorted(map(int, log.read_text().split())) == [3, 4, 6, 7, 8]
    assert [row["square"] for row in found.rows] == [k * k for k in range(9)]
    assert run_sweep(sweep, tmp_path / "out", workers=1).run == 0


def test_a_folder_of_another_sweep_is_refused(tmp_path: Path) -> None:
    swept(tmp_path, "[grid]\nn = [1, 2]\n")
    with pytest.raises(InputError, match="table of another sweep; a folder for each wanted"):
        swept(tmp_path, "[grid]\nn = [1, 3]\n")
    (tmp_path / "out" / "table.parquet").write_bytes(b"PAR1")
    with pytest.raises(InputError, match=r"table\.parquet: cannot be read as the table of a sweep"):
        swept(tmp_path, "[grid]\nn = [1, 2]\n")


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("[grid]\nfaults = [1]\n", r"unknown key 'faults' \(line 3\); did you mean 'fails'"),
        ("[grid]\nn = 3\n", r"n = 3; a list of values, or a range .* wanted \(line 3\)"),
        ("[grid]\nn = []\n", "a list of values"),
        ("[grid]\nm = [1]\n", "no 'n'"),
        ("[grid]\nn = [1]\n[fixed]\nn = 2\n", "n in .grid. and in .fixed."),
        ("[grid]\nn = [1, 2.5]\n", "n = 2.5; a whole number wanted"),
        ("[grid]\nn = { from = 1 }\n", "no 'count'"),
        ("[grid]\nn = [1]\nm = { from = 0.0, to = 1.0, count = 3, spacing = 'log' }\n", "log above 0"),
    ],
)
def test_a_wrong_file_is_refused_before_anything_runs(text: str, message: str, tmp_path: Path) -> None:
    with pytest.raises(InputError, match=message):
        swept(tmp_path, text)
    assert not (tmp_path / "out").exists()


def test_any_column_is_drawn_against_any_other(tmp_path: Path) -> None:
    rows = [{"case": k, "a": k % 3, "b": k, "c": "xy"[k % 2], "error": None} for k in range(9)]
    draw_columns(rows, *parse_plot("a,b,c"), tmp_path / "p.png")
    assert (tmp_path / "p.png").stat().st_size > 5000
    draw_columns(rows, "a", "b", None, tmp_path / "p.svg", ["c", "seed"])
    assert "mean over c, seed" in (tmp_path / "p.svg").read_text("utf-8")
    with pytest.raises(InputError, match="no column 'd' in the table; case, a, b, c, error are there"):
        draw_columns(rows, "a", "d", None, tmp_path / "q.png")


def test_transients_of_one_batch_have_the_results_of_single_runs() -> None:
    cases = [{"template": "edge", "rows": 12, "density": 0.4, "seed": seed, "z": -1.2} for seed in range(4)]
    assert len({transients.group(case) for case in cases}) == 1
    rows = transients.run(cases)
    for case, row in zip(cases, rows, strict=True):
        entry = cnnsim.library.load("edge")
        shown = transients.picture(case)
        network = entry.template
        changed = cnnsim.Template(network.A, network.B, -1.2)
        y = cnnsim.run_transient(changed, **entry.task(shown)).y
        assert row["black"] == int((y > 0).sum())
        assert row["changed"] == int(((y > 0) != (shown > 0)).sum())
        assert np.isclose(row["mean"], y.mean())
