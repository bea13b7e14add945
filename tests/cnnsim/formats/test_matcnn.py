"""Files of MATCNN: expressions, entries, terms."""

import numpy as np
import pytest

from cnnsim.formats.matcnn import entry_template, matcnn_templates, read_matcnn
from cnnsim.library.imported import Imported, plain
from cnnsim.network import Template, Term
from cnnsim.network.table import lines, steps
from cnnsim.support import Diagnostics


def matcnn(text: str) -> tuple[dict[str, Imported], Diagnostics]:
    report = Diagnostics("temlib.m")
    return {one.name: one for one in matcnn_templates(read_matcnn(text.encode(), report), report)}, report


def value(expression: str) -> np.ndarray:
    report = Diagnostics("x.m")
    entries = read_matcnn(f"Y_A = [2 4];\nX_A = {expression};".encode(), report)
    assert not report.failed, report.lines()
    return entries["X"].parts["A"]


@pytest.mark.parametrize(
    ("expression", "wanted"),
    [
        ("[1 -1 +2]", [[1, -1, 2]]),
        ("[1 - 1, 3 -4]", [[0, 3, -4]]),
        ("[1-1 2*3 .5/2]", [[0, 6, 0.25]]),
        ("[-.1 1e-1;\t2. (1 - 3)]", [[-0.1, 0.1], [2, -2]]),
        ("[1 2 % first row\n 3 4 ;\n\n 5 6]", [[1, 2], [3, 4], [5, 6]]),
        ("[1 ...the row goes on\n 2]", [[1, 2]]),
        ("1/4*[1 2;3 4]", [[0.25, 0.5], [0.75, 1]]),
        ("-(2 + [1 2])*3", [[-9, -12]]),
        ("[8 6] - Y_A/2", [[7, 4]]),
        ("Y_A .* [3 .5] ./ 2", [[3, 1]]),
        ("- -+3", 3),
        ("2 - 3 - 4", -5),
        ("16/2/4", 2),
    ],
)
def test_expressions_are_worked_out_as_matlab_does(expression: str, wanted: object) -> None:
    assert np.array_equal(value(expression), np.array(wanted, dtype=float))


@pytest.mark.parametrize(
    ("expression", "words"),
    [
        ("__import__('os')", "'_'"),
        ("eval(1)", "'eval' is not defined"),
        ("[1 2; 3]", "equal rows"),
        ("[1 2]*[3 4]", "between a matrix"),
        ("[1 2] + [3 4 5]", "between a matrix"),
        ("1/0", "division by zero"),
        ("1e308*1e308", "not finite"),
        ("[1 2", "wanted"),
        ("(1 2)", "')' wanted"),
        ("1 2", "after the end"),
        ("", "wanted"),
        ("[[1 2] 3]", "inside a matrix"),
        ("(" * 100 + "1" + ")" * 100, "nested deeper"),
        ("Z_A", "not defined"),
        ("2^3", "after the end"),
    ],
)
def test_anything_else_is_an_error_with_its_line(expression: str, words: str) -> None:
    templates, report = matcnn(f"GOOD_A = 1;\n\nX_A = {expression};\nX_I = 2;\nLAST_A = 3;")
    (error,) = report.of("error")
    assert error.line == 3
    assert words in error.message
    assert list(templates) == ["good", "last"]  # the wrong one is left out, whole


def test_entries_aliases_and_missing_parts() -> None:
    one_a, one_b = "ONE_A = [0 0 0; 0 2 0; 0 0 0];", "ONE_B = 1/2*[0 1 0;1 0 1;0 1 0];"
    templates, report = matcnn(f"% library\n{one_a}\n{one_b}\nONE_I = -1;\nTWO_B = ONE_B; TWO_I = 3\n")
    one, two = (plain(templates[name].template, "") for name in ("one", "two"))
    assert one.self_feedback == 2
    assert one.B[0, 1] == two.B[0, 1] == 0.5
    assert (one.z, two.z, two.feedback_taps) == (-1, 3, ())
    assert not report.failed
    assert all("zero-flux" in item.message for item in report.of("warning"))


def test_nonlinear_entries_become_terms() -> None:
    weights, function = "N_Dd = [.5 1 .5; 1 0 1; .5 1 .5];", "N_d = [1 3  -2 0  0 1  2 0  122];"
    report = Diagnostics("x.m")
    entries = read_matcnn(f"N_A = 1;\n{weights}\n{function}\nM_Aa = 1;\nM_a = [0 1 0 3];".encode(), report)
    (d,) = entry_template(entries["N"], "n").terms
    assert (str(d), d.table) == ("f(x_kl - x_ij) (x_kl - x_ij)", lines((-2, 0), (0, 1), (2, 0)))
    assert d.weights.tolist() == [[0.5, 1, 0.5], [1, 0, 1], [0.5, 1, 0.5]]  # neighbour minus centre, as ours
    (a,) = entry_template(entries["M"], "m").terms
    assert (str(a), a.table) == ("f(y_kl - y_ij)", steps([], [3]))
    assert [len(terms(imported)) for imported in matcnn_templates(entries, report)] == [1, 1]


def terms(imported: Imported) -> tuple[Term, ...]:
    assert isinstance(imported.template, Template)
    return imported.template.terms


@pytest.mark.parametrize("text", ["N_d = [1 1 0 0 11];", "N_Bb = 1;", "N_Aa = 1;\nN_a = [1 2 0 0];",
                                  "N_Dd = 1;\nN_d = [1 1 0 0];", "N_Dd = 1;\nN_d = [1 1 0 0 44];",
                                  "N_Aa = 1;\nN_a = [2 1 0 0];",
                                  "N_A = [1 2 3];", "N_A = 1;\nN_I = [1 2];", "x = 3;", ""])  # fmt: skip
def test_incomplete_matcnn_entries_are_errors(text: str) -> None:
    templates, report = matcnn(text)
    assert report.failed
    assert templates == {}


def test_an_unclosed_bracket_costs_one_entry_only() -> None:
    templates, report = matcnn("X_A = [1 2\nY_A = 3;\n")
    assert list(templates) == ["y"]
    assert [item.line for item in report.of("error")] == [1]
