"""Lines of text that boards print: which are frames, and which cells are no number."""

import numpy as np
import pytest

from cnnsim.support import InputError
from tactile.wire.base import Options
from tactile.wire.registry import find_format
from tests.kits.wire import decoded, pair


def test_text_lines_that_are_no_frame_are_skipped() -> None:
    decoder, _ = pair("csv", {"before": ["t_ms", "-"]})
    good = "12,x,".replace("x", "7") + ",".join(str(n) for n in range(12))
    lines = ["lost its beginning,1", good, "", "# note", "boot ok", good + ",1", good.replace("11", "1_1"), good[:-1],
             good.replace(",", " \t"), good.replace("11", "nan"), good.replace("11", "inf"), good + "*00"]  # fmt: skip
    got = decoded(decoder, "\r\n".join(lines).encode() + b"\n")
    assert [reading.t_device for reading in got] == [0.012] * 6
    assert got[2].values[-1].tolist() == [9, 10, 1]  # a truncated last number cannot be detected
    assert [np.isnan(got[n].values[-1, 2]) for n in (1, 4, 5)] == [True] * 3  # cells that are no number
    assert (decoder.counts.unfit, decoder.counts.bad_checksum) == (1, 1)
    assert decoder.unfit.startswith("15 numbers in line 6 (14 wanted): '12,7,0,")


LINE = "1,2,3,4,5,6,7,8,9,10,11,12"


@pytest.mark.parametrize(
    ("line", "lost"),
    [
        (LINE, []), (LINE + ",", []), (LINE.replace(",", ";"), []), (LINE.replace(",", "\t") + "\t", []),
        (f"[{LINE}]", []), ("(1,2,3),(4,5,6),(7,8,9),(10,11,12)", []), (LINE.replace("5", "inf"), [4]),
        (LINE.replace("5", "ovf").replace("7", ""), [4, 6]), (LINE.replace("12", "NaN,"), [11]),
        (",".join(f"{a}{n // 3}: {n + 1}" for n, a in enumerate("XYZ" * 4)), []),
        (" ".join(f"{a}={n + 1}" for n, a in enumerate("xyz" * 4)), []), (",".join(["ovf"] * 12), list(range(12))),
    ],
)  # fmt: skip
def test_lines_of_common_boards_are_frames(line: str, lost: list[int]) -> None:
    decoder = find_format("csv").decoder(Options(((2, 2),), {"before": []}))
    got = decoded(decoder, f"{line}\r\n".encode() * 50)
    values = np.array([reading.values.ravel() for reading in got])
    assert values.shape == (50, 12)
    assert np.flatnonzero(np.isnan(values[0])).tolist() == lost
    known = ~np.isnan(values[0])
    assert values[0][known].tolist() == (np.arange(12) + 1.0)[known].tolist()


def test_columns_around_the_taxels_are_skipped_and_taxels_may_have_the_normal_alone() -> None:
    extra = {"before": ["t_ms", "-state"], "after": ["-temperature"]}
    decoder = find_format("csv").decoder(Options(((1, 2),), extra, 1))
    (first, second) = decoded(decoder, b"10,ok,0.5,0.25,21.5\n20,ok,0.5,,21.5\n")
    assert (first.t_device, first.values.tolist()) == (0.01, [[0.5], [0.25]])
    assert np.isnan(second.values).ravel().tolist() == [False, True]
    assert decoded(decoder, b"boot, sensor ready, 3 errors\nhello world\n") == []
    with pytest.raises(InputError, match=r"after = .'temperature'., a list of - .or -name, which is skipped"):
        find_format("csv").decoder(Options(((1, 2),), {"after": ["temperature"]}))


def test_a_first_line_that_lost_its_beginning_is_no_frame() -> None:
    decoder = find_format("csv").decoder(Options(((1, 1),), {"before": []}))
    assert len(decoded(decoder, b"23,5,6\n123,5,6\n124,5,6\n")) == 2
