"""Non-linear, delayed and layered templates to and from .tem blocks: whose difference, which sign, which layer."""

import numpy as np
import pytest

from cnnsim import InputError
from cnnsim.formats.candy.content import TemFile
from cnnsim.formats.candy.from_terms import template_section
from cnnsim.formats.candy.parse import parse_tem
from cnnsim.formats.candy.terms import section_template
from cnnsim.formats.candy.write import write_tem
from cnnsim.formats.differences import number_differences
from cnnsim.network import AnyTemplate, LayeredTemplate, Table, Template, Term
from cnnsim.network.table import lines, steps
from cnnsim.support import Diagnostics

RING = "{0} {0} {0}\n{0} 0 {0}\n{0} {0} {0}\n"
WEIGHTS = [[1, 1, 1], [1, 0, 1], [1, 1, 1]]


def read(text: str) -> AnyTemplate:
    report = Diagnostics("x.tem")
    tem = parse_tem(text, report)
    assert not report.failed, report.lines()
    return section_template(tem.sections[0], "x")


def term_of(text: str) -> Term:
    template = read(text)
    assert isinstance(template, Template)
    (term,) = template.terms
    return term


def test_candy_differences_are_turned() -> None:
    term = term_of("NONLIN_CONTROL:\n" + RING.format("a-") + "a 0 3  -1 10  2 20  3 30\n")
    assert str(term.of) == "u_kl - u_ij"
    assert term.weights.tolist() == WEIGHTS
    assert term.table is not None
    # centre - neighbour = -(neighbour - centre): a(-1) = 10, a(2) = 20, a(2.5) = 30
    assert term.table(np.array([1.0, 0.9, -2.0, -2.1, -9.0])).tolist() == [10, 20, 20, 30, 30]


def test_values_are_not_turned() -> None:
    term = term_of("NONLIN_FEEDBACK:\n" + RING.format("a0") + "a 1 2  -1 10  1 20\n")
    assert (str(term.of), term.table) == ("y_kl", lines((-1, 10), (1, 20)))


def test_a_factor_turns_the_weights() -> None:
    term = term_of("NONLIN_D:\nx-x#x-x\n" + RING.format("d") + "d 1 3  -2 0  0 -1  2 0\n")
    assert (str(term.of), str(term.times)) == ("x_kl - x_ij", "x_kl - x_ij")
    assert term.weights.tolist() == [[-w for w in row] for row in WEIGHTS]
    assert term.table is not None
    assert term.table(np.array([-1.0, 0.0, 1.0])).tolist() == [-0.5, -1, -0.5]


def test_numbers_of_nonlinear_blocks_are_linear() -> None:
    template = read("FEEDBACK:\n5\nNONLIN_FEEDBACK:\n1 2 3\n4 a- 6\n7 8 9\na 1 1 0 1\n")
    assert isinstance(template, Template)
    assert template.A.tolist() == [[1, 2, 3], [4, 5, 6], [7, 8, 9]]
    assert [term.taps for term in template.terms] == [((0, 0, 1.0),)]


def test_delays_and_layers() -> None:
    delayed = term_of("FEEDBACK:\n1\nDELAY: 10\nDELAYED_CONTROL:\n" + RING.format(3) + "DELAYED_FEEDBACK:\n0\n")
    assert (str(delayed.of), delayed.delay, delayed.table) == ("u_kl", 10, None)
    template = read(
        "NRLAYERS 2\nLAYER 2\nFEEDBACK FROM 1\n7\nCONTROL FROM 2\n8\nCURRENT 9\nLAYER 1\nFEEDBACK FROM 1\n6\n"
        "NONLIN_FEEDBACK FROM 2\na-\na 1 1 0 1\n"
    )
    assert isinstance(template, LayeredTemplate)
    first, second = template.layers
    assert (first.self_feedback, second.B.tolist(), second.z) == (6, [[8]], 9)
    assert [(str(term.of), term.layer) for term in first.terms] == [("y_kl - y_ij", 1)]
    assert [(term.taps, term.layer) for term in second.terms] == [(((0, 0, 7.0),), 0)]


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("FEEDBACK:\n1\nFEEDBACK:\n1\n", "twice in layer 1"),
        ("NONLIN_D:\nx-u#\n1\n", "whose meaning is unknown"),
        ("NONLIN_CONTROL:\na-\na 1 2 1 0 1 0\n", "line 3"),
        ("FEEDBACK:\n" + "1 " * 13 + "\n" + ("1 " * 13 + "\n") * 12, "radius 6"),
    ],
)
def test_what_is_not_known_is_not_made_up(text: str, words: str) -> None:
    with pytest.raises(InputError, match=words):
        read(text)


LEFT = Table("step", (-0.01,), (-0.5, 0.5), "left")


@pytest.mark.parametrize(
    "template",
    [
        Template([[1]], 0, -3, terms=[Term(WEIGHTS, "u_kl - x_ij", LEFT)]),
        Template([[1]], [[2]], terms=[Term(np.array([[0.5, 1, 0.5], [1, 0, 1], [0.5, 1, 0.5]]), "x_kl - x_ij",
                                           lines((-1, 0), (0, 1), (1, 0)), "x_kl - x_ij")]),
        Template(0, 0, terms=[Term(WEIGHTS, "y_kl", steps([0.95], [0, 0.05])), Term([[1]], "y_kl", steps([], [3]))]),
        Template(0, 0, terms=[Term([[2]], "u_kl - u_ij", lines((0, 1))), Term([[3]], "y_kl - y_ij", lines((0, 1)))]),
        Template([[1]], 0, terms=[Term(WEIGHTS, "u_kl", delay=10), Term([[4]], "y_kl", delay=10)]),
        Template(0, 0, terms=[Term(np.arange(25).reshape(5, 5) - 3.0, "u_kl - u_ij", lines((-1, 0.3), (1, 0.7)))]),
        LayeredTemplate([Template([[2]], terms=[Term([[5]], "y_kl", layer=1)]),
                         Template([[1]], [[3]], 4, terms=[Term(WEIGHTS, "y_kl", LEFT.mirrored(), layer=0)])]),
    ],
)  # fmt: skip
def test_templates_with_terms_go_through_tem_unharmed(template: AnyTemplate) -> None:
    text = write_tem(TemFile((template_section(template),)))
    assert list(number_differences(read(text), template)) == []


@pytest.mark.parametrize(
    ("template", "words"),
    [
        (LayeredTemplate([Template(1), Template(1)], [1, 2]), "time constants"),
        (Template(1, terms=[Term(np.ones((1, 1, 2, 2)))]), "cell to cell"),
        (Template(1, terms=[Term(1, "y_kl", lines((0, 1)), delay=3)]), "delayed function"),
        (Template(1, terms=[Term(1, "x_kl")]), "no block"),
        (Template(1, terms=[Term(1, "u_kl - x_ij")]), "no block"),
        (Template(1, terms=[Term(1, "x_kl", lines((0, 1)))]), "no block"),
        (Template(1, terms=[Term(1, "u_kl - x_ij", steps([0], [0, 1]))]), "at the edges"),
        (Template(1, terms=[Term(1, "y_kl", lines((0, 1))), Term(1, "y_kl", lines((0, 2)))]), "two functions"),
        (Template(1, terms=[Term(1, "y_kl")]), "FEEDBACK twice"),
    ],
)
def test_what_a_tem_file_cannot_hold_is_refused(template: AnyTemplate, words: str) -> None:
    with pytest.raises(InputError, match=words):
        template_section(template)
