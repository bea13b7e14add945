"""CNNSim's text."""

import pytest

from cnnsim.formats.cnnsim_text import read_cnnsim
from cnnsim.library.imported import plain
from cnnsim.network import PERIODIC, ZERO_FLUX, fixed
from cnnsim.support import Diagnostics


@pytest.mark.parametrize(
    ("tail", "boundary"),
    [
        ("C\nConstant -1\n", fixed(-1)),
        ("Boundary\n  ZeroFlux", ZERO_FLUX),
        ("C Periodic", PERIODIC),
    ],
)
def test_cnnsim_text(tail: str, boundary: object) -> None:
    report = Diagnostics("x")
    (found,) = read_cnnsim(f"A\n0 1 0\n 0 2 0 0 0\t3\nZ\n-.5\nB 1 2 3 4 5 6 7 8 9\n{tail}".encode(), "My Name", report)
    assert plain(found.network, "").A.tolist() == [[0, 1, 0], [0, 2, 0], [0, 0, 3]]
    assert plain(found.network, "").B.tolist() == [[1, 2, 3], [4, 5, 6], [7, 8, 9]]
    assert (plain(found.network, "").z, found.boundary, found.name) == (-0.5, boundary, "my-name")
    assert not report.failed


@pytest.mark.parametrize(
    ("text", "line"),
    [("1 2 3", 1), ("A\n1 2 3\n", 2), ("A\n1 2 x\n", 2), ("Z\n1", None), ("A\nA\n", 2), ("", None)],
)
def test_cnnsim_errors_name_their_line(text: str, line: int | None) -> None:
    report = Diagnostics("x")
    assert read_cnnsim(text.encode(), "x", report) == []
    assert report.of("error")[0].line == line
