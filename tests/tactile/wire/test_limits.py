"""Largest arrays of every wire format, and recovery from single faults in formats without a check sum."""

import numpy as np
import pytest

from cnnsim.support import InputError
from tactile.wire.base import Options
from tactile.wire.registry import find_format
from tests.kits.wire import decoded, pair

LARGE = [
    ("native", ((255, 255),)), ("native", ((65, 65), (1, 255))), ("csv", ((80, 80),)), ("papillarray", ((9, 9),) * 10),
    ("paxini-fast", ((16, 15),) * 28), ("paxini-serial", ((32, 32),)), ("lowiek", ((64, 64),)), ("reskin", ((64, 64),)),
]  # fmt: skip


@pytest.mark.parametrize(("name", "shapes"), LARGE)
def test_large_arrays_are_decoded(name: str, shapes: tuple[tuple[int, int], ...]) -> None:
    options = Options(shapes, {"pillar": "force first"} if name == "papillarray" else {})
    decoder, encoder = find_format(name).decoder(options), find_format(name).encoder(options)
    boards = [np.tile([0.5, -0.5, 1.0], (taxels, 1)) for taxels in options.taxels]
    sent = encoder.preamble() + b"".join(encoder.encode(boards, n, 0.001 * n) for n in range(5))
    got = decoded(decoder, *(sent[at : at + 4096] for at in range(0, len(sent), 4096)))
    assert decoder.counts.good == len(got) == (5 * len(shapes) if name == "native" else 5)
    assert len({reading.values.tobytes() for reading in got}) == len({reading.values.shape for reading in got})


@pytest.mark.parametrize(("name", "shapes", "message"), [
    ("native", ((256, 1),), "up to 256 x 1 taxels; 256 boards of 255 x 255 at most wanted"),
    ("native", ((1, 1),) * 257, "257 boards of up to 1 x 1"),
    ("papillarray", ((40, 50),), r"1 sensors of 2000 pillars make packets of \d+ bytes; 65536 at most wanted"),
    ("papillarray", ((3, 3), (3, 4)), "3 x 3, 3 x 4 pillars; all of one shape wanted"),
    ("paxini-fast", ((200, 200),), "120006 bytes of points in a packet; 65520 at most"),
    ("paxini-fast", ((1, 1),) * 29, "29 modules; the board has slots for 28"),
    ("paxini-serial", ((150, 150),), "67500 bytes of points in a packet; 65520 at most"),
])  # fmt: skip
def test_arrays_too_large_for_a_format_are_refused(
    name: str, shapes: tuple[tuple[int, int], ...], message: str
) -> None:
    with pytest.raises(InputError, match=message):
        find_format(name).decoder(Options(shapes))


@pytest.mark.parametrize("bad", [float("nan"), float("inf"), 2e5])
def test_reskin_skips_a_frame_with_an_impossible_number(bad: float) -> None:
    decoder, encoder = pair("reskin")
    packets = [encoder.encode([np.full((5, 3), 20.0 + n)], 0, 0.0) for n in range(9)]
    packets[4] = packets[4][:40] + np.float32(bad).tobytes() + packets[4][44:]
    got = decoded(decoder, b"".join(packets))
    assert [reading.values[0, 0] for reading in got] == [20, 21, 22, 23, 25, 26, 27, 28]
    assert decoder.counts.resynchronised == 82


@pytest.mark.parametrize(("numbers", "missing", "repeated"), [
    ([1, 2, 840_304_667, 4, 5], 0, 0),  # a changed digit
    ([1, 2, 3, 1, 5, 6], 0, 0),
    ([1, 2, 2147, 2148, 2149], 2144, 0),  # a gap, confirmed by the next frame
    ([1, 2, 5, 6], 2, 0),
    ([1, 2, 5, 8, 9], 4, 0),
    ([1, 2, 5, 5, 6], 2, 1),
    ([1000, 1001, 0, 1, 2], 0, 0),  # the device restarted
    ([1, 2, 70_000, 900_000, 4, 5], 0, 0),  # two changed numbers in succession
    ([2**32 - 2, 2**32 - 1, 0, 3, 4], 2, 0),
])  # fmt: skip
def test_without_a_check_sum_the_next_frame_confirms_a_jump_of_the_number(
    numbers: list[int], missing: int, repeated: int
) -> None:
    decoder, encoder = pair("csv", {"before": ["sequence"]})
    values = [np.arange(12.0).reshape(4, 3)]
    decoded(decoder, encoder.preamble() + b"".join(encoder.encode(values, n, 0.0) for n in numbers))
    assert (decoder.counts.missing, decoder.counts.repeated) == (missing, repeated)
