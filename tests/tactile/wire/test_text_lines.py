"""Lines of text that boards print: which are frames, and which cells are no number."""

import numpy as np
import pytest

from cnnsim.support import InputError
from tactile.wire.arrange import Arrange
from tactile.wire.base import Options
from tactile.wire.description_file import parse_description
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


HEADED = """
protocol = "csv"
[layout]
time = "ms"
time_unit = "ms"
sequence = "n"
[[finger]]
name = "left"
rows = 1
cols = 2
pitch_mm = 4
depth_mm = 0
quantity = "force"
columns = "L{taxel}_{axis}"
axes = ["x", "y", "-z"]
[[finger]]
name = "right"
rows = 1
cols = 2
pitch_mm = 4
depth_mm = 0
quantity = "force"
columns = "R{taxel}_{axis}"
"""
NAMES = ["n", "ms", *(f"{side}{n}_{axis}" for axis in "zxy" for n in (1, 0) for side in "RL"), "volts"]


@pytest.mark.parametrize("mark", ["", "# "])
def test_the_columns_of_a_header_line_are_found_by_the_layout(mark: str) -> None:
    description = parse_description(HEADED, "hand.toml")
    decoder = description.wire.decoder(description.options)
    values = dict(zip(NAMES, [7, 250, *range(12), 3.3], strict=True))
    row = ",".join(map(str, values.values()))
    lines = [
        row,
        row,
        "boot ok",
        mark + ",".join(NAMES),
        row.replace("7,", "8,", 1),
        row.replace("11", "ovf"),
        row + ",1",
    ]
    got = decoded(decoder, "\r\n".join([*lines, ""]).encode())
    assert [(one.sequence, one.t_device) for one in got] == [(8, 0.25), (7, 0.25)]
    assert got[0].values.tolist() == [[values[f"{side}{n}_{axis}"] for axis in "xyz"] for side in "LR" for n in (0, 1)]
    assert np.isnan(got[1].values).sum() == 1
    assert decoder.counts.unfit == 2 + 1
    left, right = Arrange(description)(got[0], 1.0)
    assert left.values[0, 1].tolist() == [values["L1_x"], values["L1_y"], -values["L1_z"]]
    assert right.values[0, 0].tolist() == [values["R0_x"], values["R0_y"], values["R0_z"]]


def test_a_missing_header_line_and_one_of_other_columns_are_reported() -> None:
    description = parse_description(HEADED, "hand.toml")
    decoder = description.wire.decoder(description.options)
    decoded(decoder, ("1," * 14 + "1\n").encode() * 3)
    assert decoder.unfit == "no header line yet, in which the layout finds its columns: reset the board"
    wrong = ",".join(NAMES).replace("ms", "us")
    decoded(decoder, f"{wrong}\n{'1,' * 14}1\n".encode())
    assert decoder.unfit.startswith(
        "no header line that fits the layout: time 'ms': no such column; the header line has"
    )
    assert decoder.counts.good == 0
