"""What emulated devices do when the host tells them something: through a terminal, and byte by byte."""

import time
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from cnnsim.support import InputError
from tactile.serial.port import open_port
from tactile.wire.base import Options
from tactile.wire.formats.papillarray.decoder import FORMATS
from tactile.wire.formats.paxini import packet as px
from tactile.wire.packets import check_form, emulated_description, packets
from tests.kits.serial import GRIP, call, device, grip
from tests.kits.wire import pair


def told(protocol: str, *said: bytes, pause: float = 0.25) -> list[bytes]:
    """Open a looping device's port, say one thing after another, and return what came after each of them."""
    scene = grip(1.0, 1 if protocol == "paxini-serial" else 2)
    description = emulated_description(protocol, scene)
    encoder = description.wire.encoder(description.options)
    received = []
    stream = packets(description, scene, True, encoder)
    with (
        device(stream, device=encoder) as emulator,
        open_port(emulator.port, 115200) as port,
    ):
        until = time.monotonic() + 10
        while not port.read(1) and not encoder.polled and time.monotonic() < until:
            pass
        for one in said:
            port.write(one)
            begun, data = time.monotonic(), b""
            while time.monotonic() < begun + pause:
                data += port.read(max(1, port.in_waiting))
            received.append(data)
    return received


def test_papillarray_sends_at_the_rate_it_is_told() -> None:
    """The scene has 200 frames a second, so f100 leaves out every other and f250 none."""
    received = told("papillarray", b"f100\n", b"f250\n", b"f77\nrubbish\n", pause=0.5)
    decoder = FORMATS["papillarray"].decoder(Options(((2, 2), (2, 2))))
    for data, period in zip(received, (0.01, 0.005, 0.005), strict=True):
        times = [reading.t_device for reading in decoder.feed(data)]
        assert len(times) > 8  # of 50 and 100 on a machine that does nothing else
        assert np.diff(times[3:]) == pytest.approx(np.full(len(times) - 4, period), abs=1e-6)
    assert decoder.counts.missing == 0


def read(encoder: Any, decoder: Any, values: Any, n: int, t: float) -> Any:
    (reading,) = decoder.feed(encoder.encode(values, n, t))
    return reading


def test_papillarray_counts_only_what_it_sends() -> None:
    decoder, encoder = pair("papillarray")
    values = [np.zeros((9, 3))] * 2
    for n in range(5):
        read(encoder, decoder, values, n, 0.001 * n)
    encoder.receive(b"f1")
    encoder.receive(b"00\n")  # cut by the cable
    got = [n for n in range(5, 105) if decoder.feed(encoder.encode(values, n, 0.001 * n))]
    assert np.diff(got).tolist() == [10] * 9
    assert (decoder.counts.good, decoder.counts.missing) == (15, 0)


def test_papillarray_zeroes_itself_on_z() -> None:
    decoder, encoder = pair("papillarray")
    rest = [np.full((9, 3), 0.25), np.full((9, 3), -0.5)]
    assert read(encoder, decoder, rest, 0, 0.0).values[0, 0] == 0.25
    encoder.receive(b"z\n")
    during = read(encoder, decoder, rest, 1, 0.5)
    assert during.values[0, 0] == 0.25  # until the average is made
    read(encoder, decoder, rest, 2, 2.6)
    after = read(encoder, decoder, [board + 1 for board in rest], 3, 2.7)
    assert np.array_equal(after.values, np.ones((18, 3)))


def test_papillarray_starts_and_stops_slip_detection() -> None:
    encoder = FORMATS["papillarray"].encoder(Options(((3, 3),)))
    on = encoder.encode([np.zeros((9, 3))], 0, 0.0)
    encoder.receive(b"s\n")
    off = encoder.encode([np.zeros((9, 3))], 0, 0.0)
    changed = [(a, b) for a, b in zip(on[:-6], off[:-6], strict=True) if a != b]
    assert changed == [(2, 0xFE)] * 9 + [(2, 0)]  # nine pillars ineligible, the sensor off
    encoder.receive(b"S\n")
    assert encoder.encode([np.zeros((9, 3))], 0, 0.0) == on


def test_paxini_fast_obeys_its_registers() -> None:
    off, read_off, types, on, reads = told(
        "paxini-fast",
        px.fast_request(px.WRITE, px.AUTO_PUSH, b"\0"),
        bytes.fromhex("55aa0003170001 00".replace(" ", "")) + bytes([px.lrc(bytes.fromhex("55aa000317000100"))]),
        px.fast_request(px.WRITE, px.DATA_TYPE, b"\2"),
        bytes.fromhex("55aa00101700010001d8"),  # the vendor's bytes for "push on"
        px.fast_request(px.WRITE, 0x0016, b"\7"),
    )
    assert px.closed(px.PUSH + bytes.fromhex("00010000")) in off
    assert off.count(px.PUSH) <= 5  # what was on its way, the answer, and one that was made already
    assert read_off == px.closed(px.REPLY + px.FAST.pack(0, 3, 0x17, 1) + b"\0")
    assert types == px.closed(px.REPLY + px.FAST.pack(0, 0x10, 0x16, 1) + b"\0")
    bare = len(px.closed(px.PUSH + bytes(4) + bytes(2 * 12)))  # two modules of four points, no resultants
    first, *frames = on.split(px.PUSH)[1:]
    assert first == px.closed(px.PUSH + bytes.fromhex("00010000"))[2:]
    assert len(frames) > 8  # of 50 on a machine that does nothing else
    assert {len(frame) for frame in frames[1:-1]} == {bare - 2}
    assert px.closed(px.REPLY + px.FAST.pack(0, 0x90, 0x16, 0)) in reads


def test_paxini_fast_describes_itself() -> None:
    encoder = pair("paxini-fast")[1]

    def request(register: int, count: int) -> bytes:
        return encoder.receive(px.closed(px.REQUEST + px.FAST.pack(0, px.READ, register, count)))[8:-1]

    assert request(px.MODULES, 4) == bytes([1, 0, 0, 0])
    assert request(px.POINT_COUNTS, 56) == bytes([9, *[0] * 55])
    assert request(px.POINT_COUNTS + 2, 2) == bytes(2)
    assert request(px.DATA_TYPE, 1) == b"\3"


def test_paxini_boards_calibrate() -> None:
    for name, command, answer in (
        ("paxini-fast", "55aa00170200010001e6", "aa5500170200010000e7"),
        ("paxini-serial", px.slow_request(px.CALIBRATE_ONE, 3, b"\1").hex(), None),
    ):
        decoder, encoder = pair(name)
        rest = [np.full((9, 3), 0.5)]
        said = b"".join(encoder.receive(bytes([byte])) for byte in b"noise" + bytes.fromhex(command))
        assert said == bytes.fromhex(answer) if answer else len(said) == 15
        assert px.lrc(said) == 0
        encoder.encode(rest, 0, 0.0)
        encoder.encode(rest, 1, 0.2)
        (reading,) = decoder.feed(encoder.encode([rest[0] + 1], 2, 0.3))
        assert np.abs(reading.values - 1).max() < 1e-12


def test_paxini_serial_answers_only_when_asked() -> None:
    ask = bytes.fromhex("55aa09000100fb0e0400000c00") + b"\0"
    ask = ask[:-1] + bytes([px.lrc(ask[:-1])])
    nothing, one, three, wrong = told("paxini-serial", b"?", ask, 3 * ask, ask[:-1] + b"\0")
    assert nothing == b""
    length = 15 + 12
    assert (len(one), len(three)) == (length, 3 * length)
    assert wrong == px.closed(px.REPLY + px.SLOW.pack(10, 1, 0, 0xFB, 0x40E, 12) + b"\2")


def test_replies_are_no_noise_for_the_decoder() -> None:
    decoder, encoder = pair("paxini-fast")
    values = [np.full((9, 3), 1.5)]
    stream = encoder.receive(px.fast_request(px.WRITE, px.DATA_TYPE, b"\3") + px.fast_request(px.WRITE, 0x17, b"\1"))
    stream += (
        encoder.encode(values, 0, 0.0) + encoder.receive(px.fast_request(0x55, 0x17)) + encoder.encode(values, 1, 0.1)
    )
    got = [reading for byte in stream for reading in decoder.feed(bytes([byte]))]
    assert len(got) == 2
    assert decoder.counts.resynchronised == len(px.fast_request(0x55, 0x17))  # a function that no board answers
    assert decoder.counts.bad_checksum == 0


@pytest.mark.parametrize("name", ["papillarray", "paxini-fast", "paxini-serial"])
def test_devices_survive_noise_on_their_ear(name: str) -> None:
    encoder = pair(name)[1]
    rng = np.random.default_rng(0)
    for _ in range(300):
        noise = rng.bytes(50)
        encoder.receive(bytes.fromhex("55aa") + noise if rng.random() < 0.5 else noise)
    assert len(encoder._received) <= px.LONGEST + 60  # type: ignore[attr-defined]


def test_a_scene_that_no_such_device_could_have_is_refused() -> None:
    """A reader without an array description would find every frame unfit."""
    refused = call("emulate", "--protocol", "papillarray", "--scene", GRIP)
    assert refused.exit_code == 2
    assert "has arrays of 2 x 2 and 2 x 2; protocol 'papillarray' is always read as 3 x 3 and 3 x 3" in refused.stderr
    scene = grip(0.1)
    with pytest.raises(InputError, match="all of one shape wanted"):
        odd = replace(scene, arrays=(scene.arrays[0], replace(scene.arrays[1], rows=3, cols=3)))
        emulated_description("papillarray", odd)
    check_form("papillarray", replace(scene, arrays=tuple(replace(one, rows=3, cols=3) for one in scene.arrays)))
    check_form("native", scene)
