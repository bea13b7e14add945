""".tem files: dialects, blocks of all kinds, layers."""

import pytest

from cnnsim.formats.candy.content import Block, Call, FunctionLine, Header, Layer
from cnnsim.formats.candy.imported import tem_templates
from cnnsim.formats.candy.parse import read_tem
from cnnsim.library.imported import plain
from cnnsim.support import Diagnostics
from tests.kits.tem import A, parse, remarks


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
    report = Diagnostics("x.tem")
    tem = read_tem(b"%Function: M\xfcller \x96 Lyer\n" + A.encode(), report)
    assert tem.headers[0].text == "Müller \N{EN DASH} Lyer"
    assert "1252" in remarks(report, "note")[0][1]
    assert read_tem(b"%Function: \x81\xfc\n" + A.encode(), report).headers[0].text == "\x81ü"  # 0x81 is not in 1252


def test_a_missing_current_is_zero_and_noted() -> None:
    tem, report = parse("NEIGHBORHOOD: 1\n" + A)
    assert tem.sections[0].layers[0].current is None
    assert remarks(report, "note") == [(None, "no CURRENT: z = 0")]
    assert plain(tem_templates(tem, "x", Diagnostics("x"))[0].network, "").z == 0


def test_radius_changes_inside_a_file() -> None:
    five = "\n".join(["1 2 3 4 5"] * 5)
    tem, report = parse(f"NEIGHBORHOOD: 1\n{A}NEIGHBORHOOD: 2\nCONTROL:\n{five}\nCURRENT: 1")
    assert [block.radius for block in tem.sections[0].layers[0].blocks] == [1, 2]
    assert remarks(report, "warning") == []
    template = plain(tem_templates(tem, "x", Diagnostics("x"))[0].network, "")
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
        ("0 0  0 0.5", None),  # without a decimal point it is ambiguous
        ("0.0 1 0 0.5", None),  # 1.0, or two entries
        ("0.0 0\t0 0.5", None),
        ("0.0 0 0", [0.0, 0.0, 0.0]),  # of the right length as it is
    ],
)
def test_a_lost_point_is_a_warning_only_where_it_can_be_nothing_else(row: str, wanted: list[float] | None) -> None:
    report = Diagnostics("x.tem")
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
    assert layer.functions == (FunctionLine("a", False, ((-0.5, 1), (0.5, 2))), FunctionLine("b", True, ((0, 3),)))
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
    assert tem.sections[0].layers[0].functions == (FunctionLine("d", False, ((0.01, 0.5), (2.5, -0.5))),)
    assert not report.failed


def test_a_row_that_could_be_a_function_is_a_row_inside_a_matrix() -> None:
    rows = "d d d d d\nd 0 1 0 0\nd d d d d\nd d d d d\nd d d d d\n"
    tem, report = parse(f"NEIGHBORHOOD: 2\nNONLIN_D:\nX-X # x-x\n{rows}d 0 1 0 0\n")
    (block,) = tem.sections[0].layers[0].blocks
    assert block.rows[1] == (Call("d", ""), 0, 1, 0, 0)
    assert (block.argument, block.factor) == ("x-x", "x-x")
    assert tem.sections[0].layers[0].functions == (FunctionLine("d", False, ((0, 0),)),)
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
    (imported,) = tem_templates(tem, "x", Diagnostics("x"))
    assert "FEEDBACK twice" in imported.missing


def test_a_script_is_a_list_of_templates_and_a_loop() -> None:
    part = f"template: {{0}}\nnew\nneighborhood: 1\n{A}current: {{0}}\n"
    tem, report = parse("label 1\n" + part.format(1) + part.format(2) + "loop: 1 9\n")
    assert [(section.title, section.label) for section in tem.sections] == [("1", "1"), ("2", "")]
    assert tem.loop == (1, 9)
    assert not report.items
    templates = tem_templates(tem, "TURN", report)
    assert [(imported.name, plain(imported.network, "").z) for imported in templates] == [("turn-1", 1), ("turn-2", 2)]
    assert "9 times" in templates[0].note
    assert "the loop is not" in report.of("warning")[-1].message
