"""Import and export as commands, users' own libraries, real .tem files where they are at hand, and rubbish."""

import json
from pathlib import Path

import click
import numpy as np
import pytest
from click.testing import CliRunner, Result
from hypothesis import example, given
from hypothesis import strategies as st

from cnnsim import InputError, library
from cnnsim.cli_formats import export, import_
from cnnsim.command import CommandGroup
from cnnsim.formats.differences import number_differences
from cnnsim.formats.draft import Draft
from cnnsim.formats.files import READERS, import_file
from cnnsim.formats.report import Report
from cnnsim.formats.tem_parse import read_tem
from cnnsim.formats.tem_terms import section_template
from cnnsim.formats.tem_write import write_tem
from cnnsim.formats.toml_writer import template_file
from cnnsim.template import Template

HOLE = """%Function:\tFills holes.
%TemLibName:\tHoleFiller
%Setting:\tInput:P, IniState:1, Boundary:Fixed(0)
neighborhood: 1
feedback:
0 1 0
1 3 1
0 1 0
control:
0 0 0
0 4 0
0 0 0
current: -1
"""
SIX = "neighborhood: 2\ncontrol:\n0 0 0 0 0\n0 0 0 0 0\n0 0 0 0 0 0\n0 0 0 0 0\n0 0 0 0 0\n"
TWICE = "neighborhood: 0\ncontrol:\n1\ncontrol:\n2\ncurrent: 0\n"
KINDS: dict[str, tuple[str, list[object]]] = {
    "nonlinear": ("nonlin_control:\na-\na 0 1 0 .3\ncurrent: 0\n", [0.3, 0.3]),
    "delayed": ("control:\n1\ndelay: 2\ndelayed_control:\n1\ncurrent: 0\n", [0.5, 1.0]),
    "layers": ("nrlayers 2\nlayer 1\ncontrol from 1\n1\nlayer 2\nfeedback from 1\n-1\n", [[0.25, 0.5], [-0.25, -0.5]]),
    "discrete": ("%CNNModel: DT-CNN\ncontrol:\n1\ncurrent: 0\n", [1.0, 1.0]),
}


@click.group(cls=CommandGroup)
def main() -> None:
    """The two commands by themselves."""


main.add_command(import_)
main.add_command(export)


def call(*words: str | Path) -> Result:
    return CliRunner().invoke(main, [str(word) for word in words])


def plain(text: str) -> str:
    return " ".join(text.split())


# --- import -------------------------------------------------------------------------------------------------------


def test_import_writes_files_that_load_and_run(tmp_path: Path) -> None:
    (tmp_path / "HOLE.tem").write_text(HOLE)
    result = call("import", tmp_path / "HOLE.tem", "-o", tmp_path / "mine")
    assert result.exit_code == 0, result.output
    entry = library.load_file(tmp_path / "mine" / "hole.toml")
    assert not list(number_differences(entry.network, library.load("hole-filler").network))
    assert (entry.summary, entry.initial_state, str(entry.boundary)) == ("Fills holes.", 1, "fixed 0")
    assert entry.aliases == ("HOLE", "HoleFiller")
    assert entry.examples == ()
    assert not entry.shipped
    assert "white front cannot enter" in entry.note  # what the library knows of it goes along
    assert "white front cannot enter" in result.output
    with library.using(tmp_path / "mine"):
        assert library.run("hole", np.ones((3, 3)), boundary=entry.boundary).y.min() == 1


@pytest.mark.parametrize("kind", KINDS)
def test_every_kind_is_imported_and_runs(tmp_path: Path, kind: str) -> None:
    text, wanted = KINDS[kind]
    (tmp_path / f"{kind}.tem").write_text("%Setting: Input:P, IniState:0, Boundary:Fixed(0)\nneighborhood: 0\n" + text)
    result = import_file(tmp_path / f"{kind}.tem", tmp_path)
    assert [path.stem for path in result.written] == [kind], result.report.lines()
    entry = library.load_file(tmp_path / f"{kind}.toml")
    y = library.run(entry, np.array([[0.25, 0.5]]), backend="reference").y
    assert np.allclose(np.squeeze(y), np.array(wanted), atol=1e-3)
    read = section_template(read_tem(text.encode(), Report("x")).sections[0], "x")
    assert list(number_differences(read, entry.network)) == []


def test_a_bad_file_does_not_stop_the_others(tmp_path: Path) -> None:
    files = {"bad.tem": SIX, "good.tem": HOLE, "odd.tem": TWICE}
    for name, text in files.items():
        (tmp_path / name).write_text(text)
    result = call("import", *(tmp_path / name for name in files), tmp_path / "none.tem", "-o", tmp_path / "out")
    assert result.exit_code == 2
    assert [path.name for path in (tmp_path / "out").iterdir()] == ["good.toml"]
    assert f"{tmp_path / 'bad.tem'}:5: error: CONTROL: a row of 6 in a matrix of 5 columns" in result.output
    assert f"{tmp_path / 'none.tem'}: error: No such file" in result.output
    assert "odd: parsed, not written: CONTROL twice in layer 1" in result.output
    assert "4 files: 1 templates written, 1 parsed but not written, 2 files failed" in result.output


def test_import_writes_over_nothing_unless_told(tmp_path: Path) -> None:
    (tmp_path / "HOLE.tem").write_text(HOLE)
    words = ("import", tmp_path / "HOLE.tem", "-o", tmp_path)
    assert call(*words).exit_code == 0
    again = call(*words)
    assert again.exit_code == 2
    assert "is there already" in again.output
    assert call(*words, "--replace").exit_code == 0


def test_import_as_json(tmp_path: Path) -> None:
    (tmp_path / "bad.tem").write_text(SIX)
    result = call("import", tmp_path / "bad.tem", "-o", tmp_path, "--json")
    (facts,) = json.loads(result.output)
    assert facts["failed"]
    assert {"severity": "error", "line": 5} in [{k: d[k] for k in ("severity", "line")} for d in facts["diagnostics"]]


def test_formats_go_by_suffix_or_by_option(tmp_path: Path) -> None:
    (tmp_path / "g.txt").write_text("0 " * 14 + "2" + " 0" * 4)
    unknown = call("import", tmp_path / "g.txt", "-o", tmp_path)
    assert unknown.exit_code == 2
    assert "'.txt' is not known" in unknown.output
    assert call("import", tmp_path / "g.txt", "--format", "gene", "-o", tmp_path).exit_code == 0
    assert library.load_file(tmp_path / "g.toml").template.state_bound() == 2


def test_an_import_that_would_hide_a_shipped_template_says_so(tmp_path: Path) -> None:
    (tmp_path / "Edge.tem").write_text(HOLE)
    assert "hides the shipped template" in call("import", tmp_path / "Edge.tem", "-o", tmp_path).output


@pytest.mark.parametrize(
    ("name", "change", "words"),
    [
        ("DEADENDH", ("3", "1"), "z between -4 and -3.5"),
        ("HOLE", ("Fixed(0)", "Fixed(-1)"), ""),
        ("HOLE", ("-1", "-2"), "differs from the library's hole-filler: z is -2, not -1"),
        ("WAVE", ("0", "0"), "coupled, with a boundary of 0"),
        ("FLAT", ("feedback:\n0 1 0\n1 3 1\n0 1 0\n", "feedback:\n2\n"), ""),
        ("FLAT", ("feedback:\n0 1 0\n1 3 1\n0 1 0\ncontrol:\n0 0 0\n0 4 0\n0 0 0\ncurrent: -1",
                  "feedback:\n2\ncontrol:\n4\ncurrent: -5.5"), "the output is white for every input"),
        ("CNTR3", ("0", "0"), "peels past the centre"),
        ("FIGREC", ("feedback:\n0 1 0\n1 3 1\n0 1 0", "feedback:\n.5 .5 .5\n.5 4 .5\n.5 .5 .5"), "z is -1, not 3"),
    ],
)  # fmt: skip
def test_known_defects_are_warnings(tmp_path: Path, name: str, change: tuple[str, str], words: str) -> None:
    (tmp_path / f"{name}.tem").write_text(HOLE.replace(*change))
    warnings = [item.message for item in import_file(tmp_path / f"{name}.tem", tmp_path).report.of("warning")]
    mine = [message for message in warnings if "NEIGHBORHOOD" not in message]
    assert any(words in message for message in mine) if words else mine == []


def test_names_and_texts_survive_toml() -> None:
    text = 'quotes " and \\ and \x7f and tab\t and \ud800 and ü'
    draft = Draft("x", Template([[1]]), text, "r", input="none", note="n", aliases=("a",))
    import tomllib

    data = tomllib.loads(template_file(draft))
    assert data["summary"] == text.replace("\ud800", "?")
    with pytest.raises(InputError, match="not yet"):
        template_file(Draft("x", Template([[1]]), "s", "r", missing="not yet"))


# --- export -------------------------------------------------------------------------------------------------------


def test_export_and_import_again(tmp_path: Path) -> None:
    result = call("export", "edge", "hole-filler", "--format", "tem", "-o", tmp_path)
    assert result.exit_code == 0, result.output
    assert call("import", tmp_path / "hole-filler.tem", "-o", tmp_path).exit_code == 0
    entry = library.load_file(tmp_path / "hole-filler.toml")
    assert (entry.boundary, entry.initial_state) == (library.load("hole-filler").boundary, 1)
    assert call("export", "edge", "--format", "tem", "-o", tmp_path).exit_code == 2  # it is there already
    assert call("export", "edge", "--format", "tem", "-o", tmp_path, "--replace").exit_code == 0


@pytest.mark.parametrize(
    ("name", "kind", "words"),
    [("muller-lyer", "gene", "3 x 3 only"), ("laplace-solver", "gene", ""), ("edgy", "json", "did you mean")],
)
def test_export_errors_write_nothing(tmp_path: Path, name: str, kind: str, words: str) -> None:
    result = call("export", "edge", name, "--format", kind, "-o", tmp_path / "out")
    assert result.exit_code == (2 if words else 0)
    assert words in plain(result.output)
    assert (tmp_path / "out").exists() == (not words)


# --- libraries of one's own ---------------------------------------------------------------------------------------

MINIMAL = 'name = "{0}"\nsummary = "{1}"\nreference = "r"\nA = {2}\nz = 0\ninput = "none"\ninitial_state = "picture"\n'


def own(folder: Path, name: str, summary: str, a: float = 2) -> None:
    folder.mkdir(exist_ok=True)
    text = MINIMAL.format(name, summary, a) + 'boundary = "zero-flux"\nduration = "settled"\n'
    (folder / f"{name}.toml").write_text(text)


def test_later_folders_come_first(tmp_path: Path) -> None:
    first, second = tmp_path / "1", tmp_path / "2"
    own(first, "edge", "first")
    own(first, "mine", "first")
    own(second, "edge", "second")
    shipped = library.names()
    with library.using(first, second):
        assert library.load("edge").summary == "second"
        assert library.load("edge").file == second / "edge.toml"
        assert library.load("mine").summary == "first"
        assert library.load("corner").shipped
        assert library.names() == sorted([*shipped, "mine"])
        own(second, "edge", "changed later", 3)
        assert library.load("edge").template.z == 0
    assert library.names() == shipped
    assert library.load("edge").shipped


def test_add_is_for_good_and_a_second_time_moves_to_the_front(tmp_path: Path) -> None:
    own(tmp_path / "1", "x", "first")
    own(tmp_path / "2", "x", "second")
    with library.using():  # puts things back
        library.add(tmp_path / "1", tmp_path / "2")
        assert library.load("x").summary == "second"
        library.add(tmp_path / "1")
        assert library.load("x").summary == "first"
    with pytest.raises(InputError, match="no template 'x'"):
        library.load("x")


def test_a_library_that_is_no_folder(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="a folder of template files wanted"), library.using(tmp_path / "none"):
        pass


def test_shipped_templates_have_worked_examples_and_own_ones_may_do_without(tmp_path: Path) -> None:
    assert all(library.load(name).examples for name in library.names())
    own(tmp_path, "bare", "no example")
    assert library.load_file(tmp_path / "bare.toml").examples == ()


# --- rubbish in, diagnostics out ----------------------------------------------------------------------------------

pieces = st.sampled_from(
    ["FEEDBACK:", "CONTROL", "NONLIN_D:", "NONLIN_CONTROL FROM", "CURRENT", "LAYER", "NRLAYERS", "DELAY:", "LOOP",
     "NEW", "TEMPLATE", "DELAYED_CONTROL:", "NEIGHBORHOOD:", "%Setting:", "Input:P,", "Boundary:Fixed(", "x-u#",
     "a 0 1 2 3",
     "a-", "d", "0 0 0", "1", "-.5", "9e99", "\n", "\n", "\x1a", "X_A =", "X_d = [", "[", "]", ";", "(", "-", "/", "'",
     "X_A", "A", "B", "Z", "C", "Constant", '{"name":', '"feedback":', "[[1]]", "}", ",", "99999999999999999999"]
)  # fmt: skip
rubbish = st.one_of(
    st.binary(max_size=200), st.text(max_size=200).map(lambda text: text.encode("utf-8", "replace")),
    st.lists(pieces, max_size=40).map(lambda words: " ".join(words).encode()),
)  # fmt: skip


@given(rubbish)
@example(b"X_A = [" + b"(" * 5000)
@example(b"X_A = " + b"-" * 5000 + b"1")
@example(b"a 1 999999 " + b"1 " * 5000)
@example(b"%Setting: " + b" " * 3000 + b"x")
def test_rubbish_gives_diagnostics_and_nothing_else(data: bytes) -> None:
    for read in READERS.values():
        report = Report("x")
        for draft in read(data, "x", report):
            if not draft.missing:
                template_file(draft)
        report.lines(notes=True)


@given(st.text(max_size=300))
def test_what_was_read_from_any_text_is_written_and_read_the_same(text: str) -> None:
    report = Report("x")
    tem = read_tem((HOLE + text.replace("\x1a", "")).encode("utf-8", "replace"), report)
    if not report.failed:
        assert read_tem(write_tem(tem).encode(), Report("x")).sections == tem.sections


# --- real files, where they are -----------------------------------------------------------------------------------

REAL = Path(__file__).parents[2] / "shared" / "data" / "tem"
needs_real = pytest.mark.skipif(not REAL.is_dir(), reason="the real .tem files are not beside this source tree")
TWINS = {
    "AVERAGE": "averaging-threshold", "CCDMASKL": "masked-connected-components-right",
    "CCD_HOR": "connected-components-horizontal", "CENTER1": "center-point-1", "CORNER": "corner",
    "DIFFUS": "diffusion", "EDGE": "edge", "HLF5KC": "halftone-5x5-crounse", "HOLE": "hole-filler",
    "LINCUT7H": "line-remover-7-horizontal", "LOGAND": "logic-and", "LSE": "local-southern-element",
    "CONTOUR": "gray-contour", "EXTREME": "flat-places", "GLOBMAX": "global-maximum", "GRADIENT": "gradient-threshold",
    "LIFE_1L": "life-discrete-1-layer", "LOGDIFNF": "moving-parts", "MEDIAN": "median", "MOTINDEP": "slow-motion",
}  # fmt: skip
CORRECTED = {
    "LINCUT7H": ["A(+0, +1) is 1, not 0.5", "A(+0, +2) is 0.5, not 1"],
    # a difference of exactly 0.18 falls on the other side
    "CONTOUR": ["a term is f(u_kl - u_ij) at (+0, +1) [0.5, -1.0, 0.5] with steps at [-0.18, 0.18], closed left, not "
                "f(u_kl - u_ij) at (+0, +1) [0.5, -1.0, 0.5] with steps at [-0.18, 0.18], closed right"],
    # ours is MATCNN's median, with the step at 0
    "MEDIAN": ["a term is f(u_kl - x_ij) at (+0, +1) [-0.5, 0.5] with steps at [-0.01], closed left, not "
               "f(u_kl - x_ij) at (+0, +1) [-0.5, 0.5] with steps at [0.0], closed right"],
}  # fmt: skip


@needs_real
@pytest.mark.parametrize("stem", TWINS)
def test_numbers_of_real_files_are_those_of_our_templates(stem: str, tmp_path: Path) -> None:
    (target,) = import_file(REAL / f"{stem}.tem", tmp_path).written
    ours, theirs = library.load_file(target).network, library.load(TWINS[stem]).network
    assert list(number_differences(ours, theirs)) == CORRECTED.get(stem, [])


@needs_real
def test_real_files_are_read_and_the_odd_ones_are_named(tmp_path: Path) -> None:
    results = {path.stem: import_file(path, tmp_path) for path in sorted(REAL.glob("*.tem"))}
    assert [stem for stem, result in results.items() if result.report.failed] == []
    assert next(item.line for item in results["ADCONT"].report.of("warning")) == 56
    assert [stem for stem, result in results.items() if not result.written] == ["RETINA_1"]
    assert any("FEEDBACK FROM 3 again" in item.message for item in results["RETINA_1"].report.of("warning"))


@needs_real
@pytest.mark.parametrize("path", sorted(REAL.glob("*.tem")), ids=lambda path: path.stem)
def test_real_files_go_through_the_writer_unharmed(path: Path) -> None:
    report = Report(path.name)
    tem = read_tem(path.read_bytes(), report)
    again = read_tem(write_tem(tem).encode(), Report(path.name))
    assert again == tem
