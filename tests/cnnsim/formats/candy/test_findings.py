""".tem files: what is wrong or odd has its line; headers to settings; what is written reads back."""

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from cnnsim import InputError, library
from cnnsim.formats.candy.content import Block, Call, FunctionLine, Header, Layer, Section, TemFile
from cnnsim.formats.candy.imported import tem_templates
from cnnsim.formats.candy.write import entry_to_tem, write_tem
from cnnsim.formats.differences import number_differences
from cnnsim.network import PERIODIC, ZERO_FLUX, Template, fixed
from cnnsim.support import Diagnostics
from tests.kits.tem import A, parse, remarks


@pytest.mark.parametrize(
    ("text", "line", "words"),
    [
        ("CONTROL:\n1 2\n3 4\n", 2, "odd square"),
        ("CONTROL:\n1 2 3\n3 4 5\n", 2, "2 rows of 3"),
        ("CONTROL:\n1 2 3\n3 4\n1 2 3\n", 3, "a row of 2"),
        ("CONTROL:\nCURRENT: 1\n", 1, "no matrix"),
        ("CONTROL:\n1 0,5 3\n1 2 3\n1 2 3\n", 2, "decimal point"),
        ("CONTROL:\n1 nan 3\n1 2 3\n1 2 3\n", 2, "'nan' is no number"),
        ("CONTROL:\n1 1e999 3\n1 2 3\n1 2 3\n", 2, "too large"),
        ("CONTROL:\n1 a- 3\n1 2 3\n1 2 3\n", 2, "only NONLIN blocks"),
        ("NONLIN_CONTROL:\n1 a 3\n1 2 3\n1 2 3\n", 2, "a- or a0"),
        ("NONLIN_CONTROL:\na-\nCURRENT: 0", 1, "function 'a' that has no line"),
        ("NONLIN_D:\nd d d\nd 0 d\nd d d\nd 0 1 0 1", 2, "x-u#"),
        (A + "b 0 2 1 2 3\n", 5, "3 numbers, 2 pairs"),
        (A + "CURRENT: big\n", 5, "'big' is no number"),
        (A + "CURRENT:\n", 5, "CURRENT"),
        (A + "CURRENT: 1\nCURRENT: 2\n", 6, "a second CURRENT"),
        (A + "DELAY: -1\n", 5, "0 or more"),
        (A + "bias 3\n", 5, "no keyword"),
        ("FEEDBACK FROM 2\n1\n", 1, "no such layer"),
        ("FEEDBACK FROM x\n1\n", 1, "number of a layer"),
        ("NRLAYERS 2\nLAYER 1\nFEEDBACK FROM 1\n1\n", None, "1 to 2 wanted"),
        ("LAYER 1\nCONTROL:\n1\nLAYER 1\nCONTROL:\n1\n", 4, "second time"),
        ("LAYER one\nCONTROL:\n1\n", 1, "a whole number"),
        ("CONTROL:\n1\nLAYER 1\nCONTROL:\n1\n", 3, "belong to no layer"),
        ("NEIGHBORHOOD: one\n" + A, 1, "whole number"),
        (A + "LOOP: 1\n", 5, "label and times"),
        ("%Function: nothing\n", None, "no template file"),
        ("", None, "no template file"),
    ],
)  # fmt: skip
def test_an_error_names_its_line(text: str, line: int | None, words: str) -> None:
    _, report = parse(text)
    assert [at for at, message in remarks(report, "error") if words in message] == [line], report.lines()


@pytest.mark.parametrize(
    ("text", "words"),
    [
        (A + "CURRENT: 1 mA\n", "'mA'"),
        (A + "a 1 2 0 1 0 2\n", "do not ascend"),
        (A + "a 1 1 0 1\n", "not used"),
        (A + "\x1aCURRENT: 1", "0x1A"),
        ("%Function: a\n%Function: b\n" + A, "a second %Function"),
        ("DELAYED_CONTROL:\n1\nDELAY: 4\n", "after its block"),
        ("LAYER 1\nNONLIN_CONTROL:\na-\na 0 1 0 1\nLAYER 2\nNONLIN_CONTROL:\na-\n", "of another layer"),
        (A + "LOOP: 3 9\n", "LABEL 3"),
    ],
)
def test_what_is_odd_is_a_warning(text: str, words: str) -> None:
    _, report = parse(text)
    assert not report.failed, report.lines()
    assert sum(words in message for _, message in remarks(report, "warning")) == 1


@pytest.mark.parametrize(
    ("setting", "wanted"),
    [
        ("Input:P, IniState:P, Boundary:Fixed(-1)", ("picture", "picture", fixed(-1))),
        ("Input: P1 , IniState: P2, Boundary: Zero-flux", ("picture", "given", ZERO_FLUX)),
        ("Input:P, IniState:Arbitrary(0), Boundary:ZeroFlux", ("picture", "any", ZERO_FLUX)),
        ("Input:P, IniState:Arbitrary, Boundary:Torus", ("picture", "any", PERIODIC)),
        ("Input:P1, IniState:1, Boundary:Periodic", ("picture", 1, PERIODIC)),
        ("Input:P(t), IniState:P, Boundary:Fixed(.5)", ("picture", "picture", fixed(0.5))),
        ("Input:0, IniState:P, Boundary:Fixed(0)", (0, "picture", fixed(0))),
    ],
)
def test_settings(setting: str, wanted: tuple[object, ...]) -> None:
    report = Diagnostics("x")
    (imported,) = tem_templates(parse(f"%Setting: {setting}\n{A}CONTROL:\n2\n")[0], "x", report)
    assert (imported.input, imported.initial_state, imported.boundary) == wanted
    assert report.of("warning") == []


@pytest.mark.parametrize(
    "setting", ["Input:Q, IniState:P, Boundary:Fixed(0)", "Input:P, IniState:2, Boundary:Fixed(0)",
                "Input:P, IniState:P, Boundary:Fixed(3)", "Input:P, IniState:P, Boundary:open", "as you like",
                "Input:P, IniState:P", "Input:-, IniState:P, Boundary:Fixed(0)",
                "Input:P, IniState:-, Boundary:Fixed(0)"],
)  # fmt: skip
def test_settings_that_are_not_understood_are_warnings(setting: str) -> None:
    report = Diagnostics("x")
    (imported,) = tem_templates(parse(f"%Setting: {setting}\n{A}CONTROL:\n2\n")[0], "x", report)
    assert report.of("warning")
    assert imported.input == "picture"


def test_timing_and_discrete_time() -> None:
    timed, _ = parse("%Timing: 2.5 tau\n" + A)
    assert tem_templates(timed, "x", Diagnostics("x"))[0].duration == 2.5
    discrete, _ = parse("%CNNModel: Single-layer, DT-CNN\n" + A)
    assert tem_templates(discrete, "x", Diagnostics("x"))[0].cell.model == "discrete-time"
    assert tem_templates(timed, "x", Diagnostics("x"))[0].cell.model == "chua-yang"


numbers = st.floats(allow_nan=False, allow_infinity=False)

letters = st.sampled_from(["a", "b", "d", "fx"])


words = st.text("abc XYZ:(),.-0123üß", max_size=20).map(str.strip)


@st.composite
def blocks(draw: st.DrawFn, layers: int) -> Block:
    operation = draw(st.sampled_from(["feedback", "control", "nonlin_feedback", "nonlin_control", "nonlin_d",
                                      "delayed_feedback", "delayed_control"]))  # fmt: skip
    radius = draw(st.integers(0, 2))
    entry: st.SearchStrategy[object] = numbers
    if operation.startswith("nonlin"):
        of = [""] if operation == "nonlin_d" else ["-", "0"]
        entry = st.one_of(numbers, st.builds(Call, letters, st.sampled_from(of)))
    side = 2 * radius + 1
    rows = draw(st.lists(st.lists(entry, min_size=side, max_size=side).map(tuple), min_size=side, max_size=side))
    argument, factor = ("", "")
    if operation == "nonlin_d":
        argument, factor = draw(st.sampled_from([("x-u", ""), ("x-x", "x-x"), ("u-x", "x-u")]))
    source = draw(st.none() | st.integers(1, layers))
    delay = draw(st.integers(0, 20)) if operation.startswith("delayed") else None
    return Block(operation, tuple(rows), source, radius, argument, factor, delay)  # type: ignore[arg-type]  # as drawn


@st.composite
def tem_files(draw: st.DrawFn) -> TemFile:
    count = draw(st.integers(1, 3))
    layers = []
    for number in range(1, count + 1):
        own = tuple(draw(st.lists(blocks(count), min_size=1, max_size=3)))
        used = {e.letter for block in own for row in block.rows for e in row if isinstance(e, Call)}
        points = st.lists(st.tuples(numbers, numbers), min_size=1, max_size=4).map(tuple)
        functions = tuple(FunctionLine(letter, draw(st.booleans()), draw(points)) for letter in sorted(used))
        label = draw(words.map(lambda text: text.strip(" -:,."))) if count > 1 else ""
        layers.append(Layer(number, own, functions, draw(st.none() | numbers), label))
    headers = tuple(Header(key, draw(words)) for key in ("Function", "Setting"))
    comments = draw(st.lists(words.filter(bool), max_size=2).map(tuple))
    sections: tuple[Section, ...] = (Section(tuple(layers)),)
    if draw(st.booleans()):
        sections = (Section(tuple(layers), "1", "1"), Section(tuple(layers), "2"))
    return TemFile(sections, headers, comments, (1, 7) if len(sections) > 1 else None)


@settings(max_examples=40)
@given(tem_files())
def test_what_is_written_reads_back_the_same(tem: TemFile) -> None:
    again, report = parse(write_tem(tem))
    assert again == tem
    assert not report.failed, report.lines()


def test_library_templates_go_through_tem_unharmed() -> None:
    for name in library.names():
        entry = library.load(name)
        try:
            tem = entry_to_tem(entry)
        except InputError as error:
            two_values = entry.boundary.y != entry.boundary.u
            special = (
                entry.step or entry.frame_time or isinstance(entry.initial_state, tuple) or entry.cell.characteristic
            )
            kind = not isinstance(entry.network, Template) or not entry.network.linear
            assert two_values or special or kind, error  # all that a linear template can have and headers have not
            continue
        again, report = parse(write_tem(tem))
        assert again == tem
        (imported,) = tem_templates(again, name, report)
        assert report.of("warning") == report.of("error") == []
        assert list(number_differences(imported.network, entry.network)) == []
        assert (imported.name, imported.summary) == (entry.name, entry.summary)
        assert (imported.input, imported.initial_state) == (entry.input, entry.initial_state)
        assert (imported.boundary, imported.duration) == (entry.boundary, entry.duration)
        assert (imported.cell.model == "discrete-time") == (entry.cell.model == "discrete-time")
