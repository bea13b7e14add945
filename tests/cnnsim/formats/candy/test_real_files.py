"""Real .tem files where they are at hand, and rubbish."""

from collections import Counter
from pathlib import Path

import pytest
from hypothesis import example, given
from hypothesis import strategies as st

from cnnsim import library
from cnnsim.formats.candy.parse import read_tem
from cnnsim.formats.candy.write import write_tem
from cnnsim.formats.differences import number_differences
from cnnsim.formats.files import READERS, import_file
from cnnsim.support import Diagnostics
from tests.kits.formats import HOLE
from tests.kits.paths import DATA

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


LOOKED_AT: Counter[str] = Counter()
"""How many generated texts gave a template that was written, and a file that was read again."""


@given(rubbish)
@example(b"X_A = [" + b"(" * 5000)
@example(b"X_A = " + b"-" * 5000 + b"1")
@example(b"a 1 999999 " + b"1 " * 5000)
@example(b"%Setting: " + b" " * 3000 + b"x")
@example(HOLE.encode())
def test_rubbish_gives_diagnostics_and_nothing_else(data: bytes) -> None:
    for read in READERS.values():
        report = Diagnostics("x")
        for imported in read(data, "x", report):
            if not imported.missing:
                LOOKED_AT["written"] += 1
                assert "name = " in imported.text()
        report.lines(notes=True)


@given(st.text(max_size=300))
@example("")
def test_what_was_read_from_any_text_is_written_and_read_the_same(text: str) -> None:
    report = Diagnostics("x")
    tem = read_tem((HOLE + text.replace("\x1a", "")).encode("utf-8", "replace"), report)
    if not report.failed:
        LOOKED_AT["read again"] += 1
        assert read_tem(write_tem(tem).encode(), Diagnostics("x")).sections == tem.sections


def test_some_generated_texts_were_templates() -> None:
    test_rubbish_gives_diagnostics_and_nothing_else()
    test_what_was_read_from_any_text_is_written_and_read_the_same()
    assert LOOKED_AT["written"] >= 1
    assert LOOKED_AT["read again"] >= 2


REAL = DATA / "tem"

needs_real = pytest.mark.skipif(not REAL.is_dir(), reason="the real .tem files are not next to this source tree")

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
    report = Diagnostics(path.name)
    tem = read_tem(path.read_bytes(), report)
    again = read_tem(write_tem(tem).encode(), Diagnostics(path.name))
    assert again == tem
