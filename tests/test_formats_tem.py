"""CANDY .tem files: every dialect and quirk, each on a snippet of its own, and the round trip."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from cnnsim import InputError, library
from cnnsim.formats.differences import number_differences
from cnnsim.formats.draft import plain
from cnnsim.formats.report import Report
from cnnsim.formats.tem import Block, Call, Function, Header, Layer, Section, TemFile
from cnnsim.formats.tem_draft import tem_drafts
from cnnsim.formats.tem_entry import entry_to_tem
from cnnsim.formats.tem_parse import parse_tem, read_tem
from cnnsim.formats.tem_write import write_tem
from cnnsim.grid import PERIODIC, ZERO_FLUX, fixed
from cnnsim.template import Template

A = "FEEDBACK:\n0 0 0\n0 1 0\n0 0 0\n"


def parse(text: str) -> tuple[TemFile, Report]:
    report = Report("x.tem")
    return parse_tem(text, report), report


def remarks(report: Report, severity: str) -> list[tuple[int | None, str]]:
    return [(item.line, item.message) for item in report.items if item.severity == severity]


# --- dialects ---------------------------------------------------------------------------------------------------


def test_plain_file() -> None:
    tem, report = parse(
        "NEIGHBORHOOD: 1\n\nFEEDBACK:\n0 1 0\n2 3 -4\n0 5 0\n\nCONTROL:\n0 0 0\n0 6 0\n0 0 0\nCURRENT: -7\n"
    )
    (layer,) = tem.sections[0].layers
    assert layer.blocks == (
        Block("feedback", ((0, 1, 0), (2, 3, -4), (0, 5, 0)), None, 1),
        Block("control", ((0, 0, 0), (0, 6, 0), (0, 0, 0)), None, 1),
    )
    assert layer.current == -7
    assert report.items == []


@pytest.mark.parametrize(
    "text",
    [
        "Neighborhood:1\nfeedback:\n-.1 .5 2.\n0 1 0\n1e1 +0 0\ncurrent 0.0",
        "NEIGHBORHOOD 1\r\nFeedBack\r\r\n-.1\t.5\t2.\r\n\r\n0 1 0 % middle\r\n10 0 0\r\nCURRENT : 0\r\n\x1a",
        "neighborhood: 1\rfeedback:\r\t-0.1 0.5 2 \r\t0 1 0 \r\t10 0 0\rcurrent: 0\x1a\x1a\n",
    ],
)
def test_spelling_makes_no_difference(text: str) -> None:
    tem, report = parse(text)
    (layer,) = tem.sections[0].layers
    assert layer.blocks == (Block("feedback", ((-0.1, 0.5, 2), (0, 1, 0), (10, 0, 0)), None, 1),)
    assert layer.current == 0
    assert remarks(report, "warning") == remarks(report, "error") == []


def test_headers_and_comments_are_kept() -> None:
    tem, _ = parse(
        "%Function:\tDoes it: well.\n%%%%%%%\n% old: no\n% just words\n%TemLibName: - ?\ncomment more words\n" + A
    )
    assert tem.headers == (Header("Function", "Does it: well."), Header("old", "no"), Header("TemLibName", "- ?"))
    assert tem.comments == ("just words", "more words")
    assert tem.header("function").line == 1


def test_bytes_of_the_code_page_1252_are_read() -> None:
    report = Report("x.tem")
    tem = read_tem(b"%Function: M\xfcller \x96 Lyer\n" + A.encode(), report)
    assert tem.headers[0].text == "Müller \N{EN DASH} Lyer"
    assert "1252" in remarks(report, "note")[0][1]
    assert read_tem(b"%Function: \x81\xfc\n" + A.encode(), report).headers[0].text == "\x81ü"  # 0x81 is not in 1252


def test_a_missing_current_is_zero_and_noted() -> None:
    tem, report = parse("NEIGHBORHOOD: 1\n" + A)
    assert tem.sections[0].layers[0].current is None
    assert remarks(report, "note") == [(None, "no CURRENT: z = 0")]
    assert plain(tem_drafts(tem, "x", Report("x"))[0].template, "").z == 0


def test_radius_changes_inside_a_file() -> None:
    five = "\n".join(["1 2 3 4 5"] * 5)
    tem, report = parse(f"NEIGHBORHOOD: 1\n{A}NEIGHBORHOOD: 2\nCONTROL:\n{five}\nCURRENT: 1")
    assert [block.radius for block in tem.sections[0].layers[0].blocks] == [1, 2]
    assert remarks(report, "warning") == []
    template = plain(tem_drafts(tem, "x", Report("x"))[0].template, "")
    assert (template.A.shape, template.B.shape) == ((3, 3), (5, 5))


def test_a_matrix_larger_than_its_neighbourhood_counts_and_is_reported() -> None:
    tem, report = parse("NEIGHBORHOOD: 1\nCONTROL:\n" + "1 1 1 1 1\n" * 5 + "CURRENT: 0")
    assert len(tem.sections[0].layers[0].blocks[0].rows) == 5
    assert remarks(report, "warning") == [(2, "CONTROL is 5 x 5 under NEIGHBORHOOD 1; the matrix counts")]


@pytest.mark.parametrize(
    ("row", "wanted"),
    [
        ("0.0 0 0 0.5", [0.0, 0.0, 0.5]),
        ("0 0 0.0 0.5", [0.0, 0.0, 0.5]),
        ("0 0  0 0.5", None),  # without any point nobody knows
        ("0.0 1 0 0.5", None),  # 1.0, or two entries
        ("0.0 0\t0 0.5", None),
        ("0.0 0 0", [0.0, 0.0, 0.0]),  # of the right length as it is
    ],
)
def test_a_lost_point_is_a_warning_only_where_it_can_be_nothing_else(row: str, wanted: list[float] | None) -> None:
    report = Report("x.tem")
    tem = read_tem(f"NEIGHBORHOOD: 1\nCONTROL:\n1 2 3\n{row}\n1 2 3\nCURRENT: 0\n".encode(), report)
    assert report.failed == (wanted is None)
    if wanted:
        assert list(tem.sections[0].layers[0].blocks[0].rows[1]) == wanted
    assert [item.line for item in report.of("warning")] == ([4] if wanted and len(row.split()) == 4 else [])


def test_nonlinear_blocks_and_their_functions() -> None:
    text = "NEIGHBORHOOD: 1\nNONLIN_CONTROL:\na- a- a-\na- -2 b0\na- a- a-\n\na 0 2  -0.5 1\n 0.5 2\nb 1 1 0 3\n"
    tem, report = parse(text + "CURRENT: 0")
    layer = tem.sections[0].layers[0]
    assert layer.blocks[0].rows[1] == (Call("a", "-"), -2.0, Call("b", "0"))
    assert layer.functions == (Function("a", False, ((-0.5, 1), (0.5, 2))), Function("b", True, ((0, 3),)))
    assert report.items == []


@pytest.mark.parametrize(
    "order", ["{f}{h}{a}{m}", "{h}{f}{a}{m}", "{h}{a}{f}{m}", "{h}{a}{m}{f}", "{h}{a}{m}CURRENT: 1\n{f}"]
)
def test_function_lines_may_stand_anywhere(order: str) -> None:
    parts = {"f": "d 0 2 0.01 0.5 2.5 -0.5\n", "h": "NONLIN_D:\n", "a": "x-u#\n", "m": "d d d\nd 0 d\nd d d\n"}
    tem, report = parse("NEIGHBORHOOD: 1\n" + order.format(**parts))
    (block,) = tem.sections[0].layers[0].blocks
    d = Call("d", "")
    assert block.rows == ((d, d, d), (d, 0, d), (d, d, d))
    assert (block.argument, block.factor) == ("x-u", "")
    assert tem.sections[0].layers[0].functions == (Function("d", False, ((0.01, 0.5), (2.5, -0.5))),)
    assert not report.failed


def test_a_row_that_could_be_a_function_is_a_row_inside_a_matrix() -> None:
    rows = "d d d d d\nd 0 1 0 0\nd d d d d\nd d d d d\nd d d d d\n"
    tem, report = parse(f"NEIGHBORHOOD: 2\nNONLIN_D:\nX-X # x-x\n{rows}d 0 1 0 0\n")
    (block,) = tem.sections[0].layers[0].blocks
    assert block.rows[1] == (Call("d", ""), 0, 1, 0, 0)
    assert (block.argument, block.factor) == ("x-x", "x-x")
    assert tem.sections[0].layers[0].functions == (Function("d", False, ((0, 0),)),)
    assert not report.failed


def test_three_words_are_a_row_of_nonlin_d_and_a_function_that_goes_on_elsewhere() -> None:
    tem, report = parse("NONLIN_D:\nx-u#\nd 0 1\n0 d 0\nd 0 d\nd 1 1\n 0 5\nNONLIN_CONTROL:\nb 1 1\n0 6\nb-\n")
    first, second = tem.sections[0].layers[0].blocks
    assert first.rows[0] == (Call("d", ""), 0, 1)
    assert second.rows == ((Call("b", "-"),),)
    assert [function.points for function in tem.sections[0].layers[0].functions] == [((0, 5),), ((0, 6),)]
    assert not report.failed


def test_delayed_blocks_have_their_delay() -> None:
    ring = "\n1 1 1\n1 0 1\n1 1 1\n"
    tem, report = parse(f"NEIGHBORHOOD: 1\n{A}delay: 10\ndelayed_feedback:{ring}DELAYED_CONTROL:{ring}CURRENT: 0")
    assert [(b.operation, b.delay) for b in tem.sections[0].layers[0].blocks] == [
        ("feedback", None), ("delayed_feedback", 10), ("delayed_control", 10),
    ]  # fmt: skip
    assert report.items == []
    assert "DELAY" in remarks(parse(f"delayed_control:{ring}")[1], "error")[0][1]


LAYERS = "NRLAYERS 2\n{0}LAYER 1 - rods and cones\n{1}FEEDBACK FROM 1:\n1\nLAYER 2\n{1}CONTROL FROM 1\n2\nCURRENT: 3\n"


@pytest.mark.parametrize("where", [("NEIGHBORHOOD: 0\n", ""), ("", "NEIGHBORHOOD: 0\n")], ids=["once", "each layer"])
def test_layers_have_labels_sources_and_a_radius(where: tuple[str, str]) -> None:
    tem, report = parse(LAYERS.format(*where))
    assert tem.sections[0].layers == (
        Layer(1, (Block("feedback", ((1,),), 1, 0),), (), None, "rods and cones"),
        Layer(2, (Block("control", ((2,),), 1, 0),), (), 3, ""),
    )
    assert not report.failed


@pytest.mark.parametrize("words", ["1 - rods", "1: rods", "1\trods", "1, rods", "1-rods -", "1 rods."])
def test_free_words_after_a_layer_are_its_label(words: str) -> None:
    tem, report = parse(f"LAYER {words}\nCONTROL:\n1\n")
    assert [(layer.number, layer.label) for layer in tem.sections[0].layers] == [(1, "rods")]
    assert not report.failed


def test_the_same_block_twice_is_reported_and_both_are_kept() -> None:
    tem, report = parse(f"NEIGHBORHOOD: 1\n{A}{A}CURRENT: 0")
    assert len(tem.sections[0].layers[0].blocks) == 2
    assert remarks(report, "warning")[0][0] == 6
    (draft,) = tem_drafts(tem, "x", Report("x"))
    assert "FEEDBACK twice" in draft.missing


def test_a_script_is_a_list_of_templates_and_a_loop() -> None:
    part = f"template: {{0}}\nnew\nneighborhood: 1\n{A}current: {{0}}\n"
    tem, report = parse("label 1\n" + part.format(1) + part.format(2) + "loop: 1 9\n")
    assert [(section.title, section.label) for section in tem.sections] == [("1", "1"), ("2", "")]
    assert tem.loop == (1, 9)
    assert not report.items
    drafts = tem_drafts(tem, "TURN", report)
    assert [(draft.name, plain(draft.template, "").z) for draft in drafts] == [("turn-1", 1), ("turn-2", 2)]
    assert "9 times" in drafts[0].note
    assert "the loop is not" in report.of("warning")[-1].message


# --- what is wrong ----------------------------------------------------------------------------------------------


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


# --- header to setting --------------------------------------------------------------------------------------------


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
    report = Report("x")
    (draft,) = tem_drafts(parse(f"%Setting: {setting}\n{A}CONTROL:\n2\n")[0], "x", report)
    assert (draft.input, draft.initial_state, draft.boundary) == wanted
    assert report.of("warning") == []


@pytest.mark.parametrize(
    "setting", ["Input:Q, IniState:P, Boundary:Fixed(0)", "Input:P, IniState:2, Boundary:Fixed(0)",
                "Input:P, IniState:P, Boundary:Fixed(3)", "Input:P, IniState:P, Boundary:open", "as you like",
                "Input:P, IniState:P", "Input:-, IniState:P, Boundary:Fixed(0)",
                "Input:P, IniState:-, Boundary:Fixed(0)"],
)  # fmt: skip
def test_settings_that_are_not_understood_are_warnings(setting: str) -> None:
    report = Report("x")
    (draft,) = tem_drafts(parse(f"%Setting: {setting}\n{A}CONTROL:\n2\n")[0], "x", report)
    assert report.of("warning")
    assert draft.input == "picture"


def test_timing_and_discrete_time() -> None:
    timed, _ = parse("%Timing: 2.5 tau\n" + A)
    assert tem_drafts(timed, "x", Report("x"))[0].duration == 2.5
    discrete, _ = parse("%CNNModel: Single-layer, DT-CNN\n" + A)
    assert tem_drafts(discrete, "x", Report("x"))[0].discrete
    assert not tem_drafts(timed, "x", Report("x"))[0].discrete


# --- round trips --------------------------------------------------------------------------------------------------

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
        functions = tuple(Function(letter, draw(st.booleans()), draw(points)) for letter in sorted(used))
        label = draw(words.map(lambda text: text.strip(" -:,."))) if count > 1 else ""
        layers.append(Layer(number, own, functions, draw(st.none() | numbers), label))
    headers = tuple(Header(key, draw(words)) for key in ("Function", "Setting"))
    comments = draw(st.lists(words.filter(bool), max_size=2).map(tuple))
    sections: tuple[Section, ...] = (Section(tuple(layers)),)
    if draw(st.booleans()):
        sections = (Section(tuple(layers), "1", "1"), Section(tuple(layers), "2"))
    return TemFile(sections, headers, comments, (1, 7) if len(sections) > 1 else None)


@given(tem_files())
def test_what_is_written_reads_back_the_same(tem: TemFile) -> None:
    again, report = parse(write_tem(tem))
    assert again == tem
    assert not report.failed, report.lines()


@pytest.mark.parametrize("name", library.names())
def test_library_templates_go_through_tem_unharmed(name: str) -> None:
    entry = library.load(name)
    try:
        tem = entry_to_tem(entry)
    except InputError as error:
        two_values = entry.boundary.y != entry.boundary.u
        special = entry.step or entry.frame_time or isinstance(entry.initial_state, tuple) or entry.cell.characteristic
        kind = not isinstance(entry.network, Template) or not entry.network.linear
        assert two_values or special or kind, error  # all that a linear template can have and headers have not
        return
    again, report = parse(write_tem(tem))
    assert again == tem
    (draft,) = tem_drafts(again, name, report)
    assert report.of("warning") == report.of("error") == []
    assert list(number_differences(draft.template, entry.network)) == []
    assert (draft.name, draft.summary) == (entry.name, entry.summary)
    assert (draft.input, draft.initial_state) == (entry.input, entry.initial_state)
    assert (draft.boundary, draft.duration) == (entry.boundary, entry.duration)
    assert draft.discrete == (entry.cell.model == "discrete-time")
