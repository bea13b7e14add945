"""Sizes that a format can carry are decoded, larger ones refused with both numbers; one fault leaves no mark."""

import numpy as np
import pytest

from cnnsim.support import InputError
from tactile.wire.base import Options, Reading
from tactile.wire.registry import find_format
from tests.kits.wire import decoded, pair, stream

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
def test_arrays_that_no_frame_can_carry_are_refused(
    name: str, shapes: tuple[tuple[int, int], ...], message: str
) -> None:
    with pytest.raises(InputError, match=message):
        find_format(name).decoder(Options(shapes))


@pytest.mark.parametrize("bad", [float("nan"), float("inf"), 2e5])
def test_reskin_in_step_gives_out_no_number_that_a_chip_cannot_send(bad: float) -> None:
    decoder, encoder = pair("reskin")
    packets = [encoder.encode([np.full((5, 3), 20.0 + n)], 0, 0.0) for n in range(9)]
    packets[4] = packets[4][:40] + np.float32(bad).tobytes() + packets[4][44:]
    got = decoded(decoder, b"".join(packets))
    assert [reading.values[0, 0] for reading in got] == [20, 21, 22, 23, 25, 26, 27, 28]
    assert decoder.counts.resynchronised == 82


def test_reskin_in_step_goes_on_with_a_board_whose_chips_all_died() -> None:
    decoder, encoder = pair("reskin")
    alive, dead = encoder.encode([np.ones((5, 3))], 0, 0.0), b"\0" * 80 + b"\r\n"
    assert len(decoded(decoder, alive + 3 * dead)) == 4


def held_word(word: int, value: int, count: int = 60, seed: int = 2) -> tuple[list[np.ndarray], list[bytes]]:
    """Frames with a few counts of noise, in which one word of the wire stays as it is, and their packets."""
    rng, encoder = np.random.default_rng(seed), pair("lowiek")[1]
    words = rng.integers(-3000, 3000, 12) + rng.integers(-3, 4, (count, 12))
    words[:, word] = np.int16(np.uint16(~value & 0xFFFF))
    frames = [one.reshape(4, 3) * [0.150, 0.150, 0.242] for one in words]
    return frames, [encoder.encode([values], 0, 0.0) for values in frames]


@pytest.mark.parametrize("word", [0, 1, 6, 11])
@pytest.mark.parametrize("value", [0xAAAA, 0xAA13, 0x31AA])
def test_lowiek_finds_its_phase_beside_a_word_that_stays_a_start_byte(word: int, value: int) -> None:
    frames, packets = held_word(word, value)
    assert packets[0][1 + 2 * word : 3 + 2 * word] == value.to_bytes(2, "big")
    truth = {values.tobytes() for values in frames}
    for lost in (0, 1, 2, 6, 13, 14, 23, 24):  # one byte of one frame
        sent = b"".join(packets[:20]) + packets[20][:lost] + packets[20][lost + 1 :] + b"".join(packets[21:])
        got = [reading.values.tobytes() for reading in decoded(pair("lowiek")[0], sent)]
        assert sum(values in truth for values in got) >= 54
        assert sum(values not in truth for values in got) <= 2


def test_lowiek_leaves_a_wrong_phase_that_once_looked_right() -> None:
    """At the start nothing tells a last word AAAA from a first one; as soon as it moves, the frames do."""
    frames, packets = held_word(11, 0xAAAA)
    moved = np.array(
        [np.vstack([values[:3], values[3:] + np.array([0, 0, 0.242 * (n % 7)])]) for n, values in enumerate(frames)]
    )
    later = [pair("lowiek")[1].encode([values], 0, 0.0) for values in moved]
    got = decoded(pair("lowiek")[0], (b"".join(packets) + b"".join(later))[3:])
    truth = {reading.tobytes() for reading in [*frames, *moved]}
    right = [reading.values.tobytes() in truth for reading in got]
    assert not any(right[:50])  # a limit of the format
    assert all(right[72:])


def lines(numbers: list[int]) -> list[Reading]:
    decoder, encoder = pair("csv", {"before": ["sequence"]})
    values = [np.arange(12.0).reshape(4, 3)]
    got = decoded(decoder, encoder.preamble() + b"".join(encoder.encode(values, n, 0.0) for n in numbers))
    got.append(Reading(values[0], decoder.counts.missing, sequence=decoder.counts.repeated))
    return got


@pytest.mark.parametrize(("numbers", "missing", "repeated"), [
    ([1, 2, 840_304_667, 4, 5], 0, 0),  # a changed digit
    ([1, 2, 3, 1, 5, 6], 0, 0),
    ([1, 2, 2147, 2148, 2149], 2144, 0),  # a gap, which the next frame confirms
    ([1, 2, 5, 6], 2, 0),
    ([1, 2, 5, 8, 9], 4, 0),
    ([1, 2, 5, 5, 6], 2, 1),
    ([1000, 1001, 0, 1, 2], 0, 0),  # a device that began anew
    ([1, 2, 70_000, 900_000, 4, 5], 0, 0),  # two changed one after the other, the second instead of frame 3... 4
    ([2**32 - 2, 2**32 - 1, 0, 3, 4], 2, 0),
])  # fmt: skip
def test_a_leap_of_a_number_without_a_checksum_needs_the_next_frame(
    numbers: list[int], missing: int, repeated: int
) -> None:
    *_, last = lines(numbers)
    assert (last.end, last.sequence) == (missing, repeated)


def test_a_leap_of_a_number_with_a_checksum_counts_at_once() -> None:
    decoder, encoder = pair("csv", {"check": True})
    values = [np.zeros((4, 3))]
    decoder.feed(encoder.preamble() + b"".join(encoder.encode(values, n, 0.0) for n in (1, 2, 900)))
    assert decoder.counts.missing == 897


def test_a_number_beyond_all_numbers_is_no_reading() -> None:
    packets, _ = stream("csv", {}, 3)
    line = packets[1].replace(packets[1].split(b",")[5], b"1e999", 1)
    assert len(decoded(pair("csv")[0], packets[0] + line + packets[2])) == 2
