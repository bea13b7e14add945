"""Wire formats: round trip, any chunking of the stream, transmission faults, sequence numbers, options."""

from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from cnnsim.support import InputError
from tactile.wire.base import Options
from tactile.wire.reading import Reading
from tactile.wire.registry import NAMES, find_format
from tests.kits.wire import SHAPES, VARIANTS, decoded, pair, signals, stream


def same(got: list[Reading], wanted: list[np.ndarray], name: str, mode: str = "") -> None:
    assert len(got) == len(wanted)
    tolerance = 2e-4 * 3 if mode == "force" else 1e-9
    for reading, values in zip(got, wanted, strict=True):
        assert np.abs(reading.values - values).max() <= tolerance * max(1.0, float(np.abs(values).max()))


@pytest.mark.parametrize(("name", "extra"), VARIANTS)
def test_packets_round_trip(name: str, extra: dict[str, Any]) -> None:
    packets, wanted = stream(name, extra, 12)
    decoder = pair(name, extra)[0]
    got = decoded(decoder, b"".join(packets))
    if extra.get("mode") == "force":
        wanted = [np.clip(values, (-10, -10, -30), (10, 10, 30)) for values in wanted]
    same(got, wanted, name, extra.get("mode", ""))
    counts = decoder.counts.plain()
    preamble = len(pair(name, extra)[1].preamble()) if name == "csv" else 0
    assert counts == {**dict.fromkeys(counts, 0), "good": len(wanted), "resynchronised": preamble}
    assert got[-1].end == len(b"".join(packets))


@pytest.mark.parametrize(("name", "extra"), VARIANTS)
@given(data=st.data())
@settings(max_examples=60, deadline=None)
def test_chunking_does_not_change_the_readings(name: str, extra: dict[str, Any], data: st.DataObject) -> None:
    """A stream with lost, added, changed and repeated bytes decodes alike in one chunk, many or single bytes."""
    packets, _ = stream(name, extra, 8, seed=data.draw(st.integers(0, 3)))
    for _ in range(data.draw(st.integers(0, 3))):
        at = data.draw(st.integers(0, len(packets) - 1))
        cut = data.draw(st.integers(0, len(packets[at])))
        change = data.draw(st.sampled_from(["lose", "add", "flip", "again"]))
        noise = data.draw(st.binary(max_size=40))
        old = packets[at]
        packets[at] = {
            "lose": old[:cut] + old[cut + 1 + len(noise) :],
            "add": old[:cut] + noise + old[cut:],
            "flip": old[:cut] + bytes(b ^ 0x10 for b in old[cut : cut + 1]) + old[cut + 1 :],
            "again": old + old,
        }[change]
    whole = b"".join(packets)
    cuts = sorted(data.draw(st.lists(st.integers(0, len(whole)), max_size=12)))
    one, many, single = (pair(name, extra)[0] for _ in range(3))
    expected = decoded(one, whole)
    pieces = [whole[a:b] for a, b in zip([0, *cuts], [*cuts, len(whole)], strict=True)]
    for decoder, chunks in ((many, pieces), (single, [whole[i : i + 1] for i in range(len(whole))])):
        got = decoded(decoder, *chunks)
        assert decoder.counts == one.counts
        assert [(r.end, r.device, r.sequence) for r in got] == [(r.end, r.device, r.sequence) for r in expected]
        for a, b in zip(got, expected, strict=True):
            assert np.array_equal(a.values, b.values, equal_nan=True)


@pytest.mark.parametrize(("name", "extra"), VARIANTS)
@pytest.mark.parametrize("seed", range(3))
def test_no_good_frame_is_lost_after_garbage(name: str, extra: dict[str, Any], seed: int) -> None:
    packets, _ = stream(name, extra, 20)
    decoder = pair(name, extra)[0]
    clean = decoded(pair(name, extra)[0], b"".join(packets))
    noise = np.random.default_rng(seed).bytes(300) + (b"\n" if name == "csv" else b"\0" if name == "native" else b"")
    head, tail = b"".join(packets[:10]), b"".join(packets[10:])
    got = decoded(decoder, head + noise + tail)
    ends = {reading.end: reading.values for reading in got}
    lost = 0
    for reading in clean:
        end = reading.end + (len(noise) if reading.end > len(head) else 0)
        lost += end not in ends or not np.array_equal(ends[end], reading.values)
    assert lost == 0
    assert decoder.counts.resynchronised >= 300


@pytest.mark.parametrize(("name", "extra"), VARIANTS)
def test_a_lost_byte_costs_at_most_two_frames(name: str, extra: dict[str, Any]) -> None:
    packets, _ = stream(name, extra, 20)
    clean = decoded(pair(name, extra)[0], b"".join(packets))
    for at in range(3, len(packets[10]), max(1, len(packets[10]) // 7)):
        short = [*packets[:10], packets[10][:at] + packets[10][at + 1 :], *packets[11:]]
        got = decoded(pair(name, extra)[0], b"".join(short))
        truth = {reading.values.tobytes() for reading in clean}
        wrong = sum(reading.values.tobytes() not in truth for reading in got)
        assert len(got) - wrong >= len(clean) - (2 if name != "native" else 1)
        # without a check sum, the frame that lost a byte may still be decoded
        assert wrong <= (1 if name in ("reskin", "lowiek", "csv") and not extra.get("check") else 0)


def test_sequence_numbers_are_counted() -> None:
    decoder, encoder = pair("papillarray")
    values = [np.zeros((9, 3))] * 2
    for number in (2**32 - 2, 2**32 - 1, 0, 0, 3, 4, 1_000_000, 1_000_001, 5, 6):
        decoder.feed(encoder.encode(values, number, 0.0))
    # 1 and 2; 5 to 999 999; then a step back: the device restarted
    assert (decoder.counts.good, decoder.counts.repeated, decoder.counts.missing) == (9, 1, 2 + 999_995)
    for number in (7, 8_000_000, 9):  # a number that jumps for one packet is ignored
        decoder.feed(encoder.encode(values, number, 0.0))
    assert decoder.counts.missing == 2 + 999_995


@pytest.mark.parametrize("name", ["papillarray", "native"])
@pytest.mark.parametrize(("numbers", "missing"), [
    ([0, 1, 3, 2, 4, 5, 7, 6, 8, 9], 0), ([0, 3, 1, 2, 4, 5, 6], 0), ([0, 1, 4, 3, 5, 6], 1), ([0, 2, 4, 6, 7], 3),
    ([0, 1, 2, 9, 10, 0, 1, 2], 6), ([0, 1, 3, 4, 2, 5, 6], 0),
])  # fmt: skip
def test_neighbours_that_swap_places_are_not_missing(name: str, numbers: list[int], missing: int) -> None:
    (decoder, encoder), boards = pair(name), signals(name, 1)[0]
    got = [reading for n in numbers for reading in decoder.feed(encoder.encode(boards, n, 0.0))]
    count = len(got) // len(numbers)  # frames of each number
    assert [reading.sequence for reading in got[::count]] == numbers
    assert (decoder.counts.missing, decoder.counts.repeated) == (missing * count, 0)


@pytest.mark.parametrize("name", ["papillarray", "native"])
@pytest.mark.parametrize("noisy", [True, False])
def test_frames_of_a_number_that_stands_still_are_kept(name: str, noisy: bool) -> None:
    (decoder, encoder), frames = pair(name), signals(name, 200) if noisy else signals(name, 1) * 200
    got = [reading for boards in frames for reading in decoder.feed(encoder.encode(boards, 7, 0.0))]
    assert len(got) >= (200 if noisy else 180) * (2 if name == "native" else 1)
    assert "stands still at 7" in decoder.trouble
    assert {reading.sequence for reading in got[-100:]} == {None}
    assert [bool(decoder.feed(encoder.encode(frames[0], 8, 0.0))) for _ in range(2)] == [
        True,
        False,
    ]  # a repeated frame
    assert decoder.counts.missing == 0


def test_papillarray_decodes_start_and_end_bytes_inside_floats() -> None:
    decoder, encoder = pair("papillarray")
    marker = np.frombuffer(bytes.fromhex("aabbccdd55667788aabbccdd"), "<f4").astype(np.float64)
    boards = [np.tile(marker, (9, 1)), np.zeros((9, 3))]
    with np.errstate(over="ignore"):
        packet = encoder.encode(boards, 1, 0.0)
    assert packet.count(bytes.fromhex("aabbccdd")) > 10
    got = decoder.feed(packet)
    assert [reading.end for reading in got] == [len(packet)]
    assert np.array_equal(got[0].values[0], marker)
    assert decoder.counts.bad_checksum == 0


def test_papillarray_detects_its_variant_under_load() -> None:
    for pillar, slip in (("force first", 2), ("displacement first", 1)):
        decoder, encoder = pair("papillarray", {"pillar": pillar, "slip_entry": slip})
        decoder.feed(encoder.encode([np.zeros((9, 3))] * 2, 1, 0.0))
        assert decoder.settled() == {"pillar": None, "slip_entry_type_bytes": slip}
        load = [np.full((9, 3), 0.5), np.zeros((9, 3))]
        (reading,) = decoder.feed(encoder.encode(load, 2, 0.0))
        assert np.array_equal(reading.values, np.concatenate(load))
        assert str(decoder.settled()["pillar"]).startswith(pillar)


def test_lowiek_decodes_start_bytes_inside_words() -> None:
    """A constant word AA xx looks like a start byte in every frame; the noise of the other words decides."""
    encoder = pair("lowiek")[1]
    rng = np.random.default_rng(1)
    rest = np.array([[0x5510, 100, 200], [0x5520, 0x5530, 7], [1, 2, 0x5540], [5, 6, 7]])
    frames = [(rest + rng.integers(-9, 10, rest.shape)) * [0.150, 0.150, 0.242] for _ in range(30)]
    whole = b"".join(encoder.encode([values], 0, 0.0) for values in frames)
    for start in range(1, 25):
        got = decoded(pair("lowiek")[0], whole[start:])
        same(got, frames[1:], "lowiek")


def test_lowiek_unwraps_a_field_beyond_the_16_bit_range() -> None:
    decoder, encoder = pair("lowiek")
    fields = [np.tile([n * 200.0, -n * 200.0, 0.0], (4, 1)) for n in range(120)]
    got = decoded(decoder, b"".join(encoder.encode([values], 0, 0.0) for values in fields))
    assert len(got) == 120
    assert np.abs(np.array([r.values for r in got]) - fields).max() <= 0.121 + 1e-9
    assert got[-1].values[0, 0] > 2**15 * 0.150


def test_a_changed_bit_leaves_no_offset_in_later_lowiek_fields() -> None:
    """The highest bit of a word is half of the range, where unwrapping from the previous value is ambiguous."""
    encoder = pair("lowiek")[1]
    fields = [np.full((4, 3), 3.0 * (n % 5 - 2)) * [0.150, 0.150, 0.242] for n in range(40)]
    packets = [bytearray(encoder.encode([values], 0, 0.0)) for values in fields]
    for n in range(10, 30):
        packets[n][1 + n % 24 // 2 * 2] ^= 0x80
    got = [reading.values for reading in decoded(pair("lowiek")[0], b"".join(packets))]
    wrong = [n for n in range(40) if np.abs(got[n] - fields[n]).max() > 1e-9]
    assert wrong == list(range(10, 30))
    assert all((np.abs(got[n] - fields[n]) > 1e-9).sum() == 1 for n in wrong)


def test_frames_of_another_shape_are_counted_and_skipped() -> None:
    for name in ("native", "papillarray", "paxini-fast", "csv"):
        other = find_format(name).encoder(Options(((4, 4),) * len(SHAPES[name])))
        decoder = pair(name)[0]
        packet = other.encode([np.ones((16, 3))] * len(SHAPES[name]), 1, 0.0)
        assert decoder.feed(other.preamble() + packet) == []
        assert decoder.counts.unfit >= 1, name


def test_wrong_options_are_refused() -> None:
    assert set(NAMES) == set(SHAPES)
    with pytest.raises(InputError, match="one of reskin"):
        find_format("morse")
    for name, extra, message in (
        ("native", {"value": "int8"}, "'float32' or 'int16' wanted"),
        ("csv", {"before": ["when"]}, "a list of sequence"),
        ("lowiek", {"mode": "colour"}, "'field' or 'force' wanted"),
        ("paxini-fast", {"resultant": 1}, "true or false wanted"),
    ):
        with pytest.raises(InputError, match=message):
            pair(name, extra)
    with pytest.raises(InputError, match="this board has 1"):
        find_format("paxini-serial").decoder(Options(((2, 2), (2, 2))))
