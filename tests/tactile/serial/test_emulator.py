"""Commands of the host to emulated devices, through a terminal and byte by byte."""

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


def replies(protocol: str, *commands: bytes, pause: float = 0.25) -> list[bytes]:
    """Open the port of a looping device, send the commands, and return the bytes received after each of them."""
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
        for one in commands:
            port.write(one)
            begun, data = time.monotonic(), b""
            while time.monotonic() < begun + pause:
                data += port.read(max(1, port.in_waiting))
            received.append(data)
    return received


def test_papillarray_sends_at_the_requested_rate() -> None:
    """The scene has 200 frames/s, so f100 sends every second frame and f250 all of them."""
    received = replies("papillarray", b"f100\n", b"f250\n", b"f77\nrubbish\n", pause=0.5)
    decoder = FORMATS["papillarray"].decoder(Options(((2, 2), (2, 2))))
    for data, period in zip(received, (0.01, 0.005, 0.005), strict=True):
        times = [reading.t_device for reading in decoder.feed(data)]
        assert len(times) > 8  # 50 and 100 on an idle machine
        assert np.diff(times[3:]) == pytest.approx(np.full(len(times) - 4, period), abs=1e-6)
    assert decoder.counts.missing == 0


def read(encoder: Any, decoder: Any, values: Any, n: int, t: float) -> Any:
    (reading,) = decoder.feed(encoder.encode(values, n, t))
    return reading


def test_papillarray_tares_on_z() -> None:
    decoder, encoder = pair("papillarray")
    rest = [np.full((9, 3), 0.25), np.full((9, 3), -0.5)]
    assert read(encoder, decoder, rest, 0, 0.0).values[0, 0] == 0.25
    encoder.receive(b"z\n")
    during = read(encoder, decoder, rest, 1, 0.5)
    assert during.values[0, 0] == 0.25  # until the mean is known
    read(encoder, decoder, rest, 2, 2.6)
    after = read(encoder, decoder, [board + 1 for board in rest], 3, 2.7)
    assert np.array_equal(after.values, np.ones((18, 3)))


def test_paxini_fast_registers() -> None:
    off, read_off, types, on, reads = replies(
        "paxini-fast",
        px.fast_request(px.WRITE, px.AUTO_PUSH, b"\0"),
        bytes.fromhex("55aa0003170001 00".replace(" ", "")) + bytes([px.lrc(bytes.fromhex("55aa000317000100"))]),
        px.fast_request(px.WRITE, px.DATA_TYPE, b"\2"),
        bytes.fromhex("55aa00101700010001d8"),  # the vendor's bytes for "push on"
        px.fast_request(px.WRITE, 0x0016, b"\7"),
    )
    assert px.closed(px.PUSH + bytes.fromhex("00010000")) in off
    assert off.count(px.PUSH) <= 5  # packets in transit, the reply, and one already encoded
    assert read_off == px.closed(px.REPLY + px.FAST.pack(0, 3, 0x17, 1) + b"\0")
    assert types == px.closed(px.REPLY + px.FAST.pack(0, 0x10, 0x16, 1) + b"\0")
    bare = len(px.closed(px.PUSH + bytes(4) + bytes(2 * 12)))  # two modules of four points, no resultants
    first, *frames = on.split(px.PUSH)[1:]
    assert first == px.closed(px.PUSH + bytes.fromhex("00010000"))[2:]
    assert len(frames) > 8  # 50 on an idle machine
    assert {len(frame) for frame in frames[1:-1]} == {bare - 2}
    assert px.closed(px.REPLY + px.FAST.pack(0, 0x90, 0x16, 0)) in reads


def test_paxini_boards_calibrate() -> None:
    for name, command, answer in (
        ("paxini-fast", "55aa00170200010001e6", "aa5500170200010000e7"),
        ("paxini-serial", px.slow_request(px.CALIBRATE_ONE, 3, b"\1").hex(), None),
    ):
        decoder, encoder = pair(name)
        rest = [np.full((9, 3), 0.5)]
        reply = b"".join(encoder.receive(bytes([byte])) for byte in b"noise" + bytes.fromhex(command))
        assert reply == bytes.fromhex(answer) if answer else len(reply) == 15
        assert px.lrc(reply) == 0
        encoder.encode(rest, 0, 0.0)
        encoder.encode(rest, 1, 0.2)
        (reading,) = decoder.feed(encoder.encode([rest[0] + 1], 2, 0.3))
        assert np.abs(reading.values - 1).max() < 1e-12


def test_paxini_serial_answers_only_requests() -> None:
    ask = bytes.fromhex("55aa09000100fb0e0400000c00") + b"\0"
    ask = ask[:-1] + bytes([px.lrc(ask[:-1])])
    nothing, one, three, wrong = replies("paxini-serial", b"?", ask, 3 * ask, ask[:-1] + b"\0")
    assert nothing == b""
    length = 15 + 12
    assert (len(one), len(three)) == (length, 3 * length)
    assert wrong == px.closed(px.REPLY + px.SLOW.pack(10, 1, 0, 0xFB, 0x40E, 12) + b"\2")


def test_the_decoder_skips_replies_to_commands() -> None:
    decoder, encoder = pair("paxini-fast")
    values = [np.full((9, 3), 1.5)]
    stream = encoder.receive(px.fast_request(px.WRITE, px.DATA_TYPE, b"\3") + px.fast_request(px.WRITE, 0x17, b"\1"))
    stream += (
        encoder.encode(values, 0, 0.0) + encoder.receive(px.fast_request(0x55, 0x17)) + encoder.encode(values, 1, 0.1)
    )
    got = [reading for byte in stream for reading in decoder.feed(bytes([byte]))]
    assert len(got) == 2
    assert decoder.counts.resynchronised == len(px.fast_request(0x55, 0x17))  # a function that boards do not answer
    assert decoder.counts.bad_checksum == 0


def test_a_scene_of_another_shape_than_the_device_is_refused() -> None:
    refused = call("emulate", "--protocol", "papillarray", "--scene", GRIP)
    assert refused.exit_code == 2
    assert "has arrays of 2 x 2 and 2 x 2; protocol 'papillarray' is always read as 3 x 3 and 3 x 3" in refused.stderr
    scene = grip(0.1)
    with pytest.raises(InputError, match="all of one shape wanted"):
        odd = replace(scene, arrays=(scene.arrays[0], replace(scene.arrays[1], rows=3, cols=3)))
        emulated_description("papillarray", odd)
    check_form("papillarray", replace(scene, arrays=tuple(replace(one, rows=3, cols=3) for one in scene.arrays)))
    check_form("native", scene)
