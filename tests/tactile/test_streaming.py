"""Streams for control loops: Python iterators of files and ports, datagrams and JSON lines of every frame."""

import asyncio
import json
import math
import socket
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import msgpack  # type: ignore[import-untyped]  # it ships no types
import numpy as np
import pytest

import tactile
from cnnsim.support import InputError
from tactile import pipeline
from tactile.core.frame import TaxelArray
from tactile.inverse.load import Load
from tactile.output.publish import Publisher, udp_address
from tactile.output.stream_frame import SlipMargins, StreamFrame
from tactile.sources.convert import convert
from tactile.sources.replay_npz import write_npz
from tactile.wire.packets import emulated_description, packets
from tests.kits.paths import ROOT
from tests.kits.serial import call, device, grip, lines, write_array


@pytest.fixture(scope="module")
def recording(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("stream") / "grip.npz"
    write_npz(path, grip(0.7))
    return path


def test_a_file_gives_tared_frames_with_load_code_margin_and_the_events_of_a_run(recording: Path) -> None:
    reports: list[pipeline.FrameReport] = []
    pipeline.run(tactile.open_source(recording), tactile.Settings(), [reports.append])
    with tactile.stream(recording) as frames:
        assert [array.name for array in frames.arrays] == ["left", "right"]
        got = list(frames)
    assert len(got) == len(reports) == 280
    for frame, report in zip(got, reports, strict=True):
        assert np.array_equal(frame.values, report.frame.values)
        assert (frame.t, frame.finger, frame.sequence) == (report.frame.t, report.array.name, report.frame.sequence)
        assert frame.code.ternary() == report.code.ternary()
        assert [event.words for event in frame.begun] == [event.words for event in report.events]
        assert [(event.kind, event.end) for event in frame.ended] == [(one.kind, one.end) for one in report.ended]
        assert math.isnan(frame.slip_margin) or 0 <= frame.slip_margin <= 1
    held = next(frame for frame in got for event in frame.begun if event.kind == "contact")
    assert math.hypot(held.centre[0] - 0.2e-3, held.centre[1] + 0.3e-3) < 0.05e-3  # where the scene presses
    assert math.isnan(got[0].slip_margin)

    async def collect() -> list[StreamFrame]:
        return [frame async for frame in tactile.stream(recording)]

    again = asyncio.run(collect())
    assert [(one.t, one.finger, one.load.validity) for one in again] == [(o.t, o.finger, o.load.validity) for o in got]


LAYOUT = """
[layout]
time = "t"
[[finger]]
name = "pad"
rows = 1
cols = 2
pitch_mm = 4.0
depth_mm = 0.0
quantity = "force"
columns = ["x0", "y0", "z0", "x1", "y1", "z1"]
"""


def test_a_table_of_another_program_is_streamed_with_its_layout(tmp_path: Path, recording: Path) -> None:
    rows = [f"{n / 100},{','.join(f'{0.3 * (n > 80) + 0.001 * ((n * k) % 7):.3f}' for k in range(2, 8))}"
            for n in range(120)]  # fmt: skip
    (tmp_path / "t.csv").write_text("\n".join(["t,x0,y0,z0,x1,y1,z1", *rows]) + "\n")
    array = write_array(tmp_path, LAYOUT)
    with tactile.stream(tmp_path / "t.csv", array) as frames:
        begun = [event.kind for frame in frames for event in frame.begun]
    assert "contact" in begun
    native = write_array(tmp_path, emulated_description("native", grip(0.1, 1)).text)
    with pytest.raises(InputError, match=r"has arrays left 2 x 2, right 2 x 2; the array description has left 2 x 2"):
        tactile.stream(recording, native)


def test_the_slip_margin_is_the_distance_from_the_limit_of_friction() -> None:
    margins, sliding = SlipMargins(0.5), [SimpleNamespace(kind="slip")]

    def margin(q: float, f: float, events: Any = (), touched: bool = True, shear: bool = True) -> float:
        code = SimpleNamespace(pressed=int(touched))
        made = SimpleNamespace(load=Load(Q=q, R=0.0, F=f), array=SimpleNamespace(name="a", shear=shear),
                               code=code, events=events)  # fmt: skip
        report: Any = made
        return margins(report)

    assert margin(0.0, 2.0) == 1
    assert margin(0.25, 2.0) == pytest.approx(0.75)
    assert margin(3.0, 2.0) == 0
    assert math.isnan(margin(0.1, 2.0, touched=False))
    assert math.isnan(margin(float("nan"), 2.0))
    assert math.isnan(margin(0.0, 2.0, shear=False))
    assert margin(1.6, 2.0, sliding) == 0  # friction is 0.8, as measured
    assert margin(0.8, 2.0) == pytest.approx(0.5)


def opened(port: str, array: Path) -> tactile.Stream:
    return tactile.stream(port, array, tactile.Settings(), seconds=5)


def test_a_port_gives_frames_until_it_is_closed(tmp_path: Path) -> None:
    scene = grip(0.5)
    description = emulated_description("native", scene)
    array = write_array(tmp_path, description.text)
    with device(packets(description, scene)) as emulator, opened(emulator.port, array) as frames:
        got = []
        for frame in frames:
            got.append(frame)
            if len(got) == 2 * 70:
                frames.close()
    assert len(got) >= 2 * 70
    first = got[0].sequence
    assert [frame.sequence for frame in got[::2]] == list(range(first, first + len(got) // 2))
    assert abs(got[-1].unix_s - got[0].unix_s - (got[-1].t - got[0].t)) < 1e-3
    assert [event.finger for frame in got for event in frame.begun if event.kind == "contact"] == ["left", "right"]
    with pytest.raises(InputError, match="a port, and no array"):
        tactile.stream("/dev/ttyACM0")
    with pytest.raises(InputError, match="no scene or recording"):
        tactile.stream("nothing.npz")


@pytest.fixture
def listener() -> Iterator[socket.socket]:
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as one:
        one.bind(("127.0.0.1", 0))
        one.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 2**22)
        one.settimeout(0.1)
        yield one


def received(listener: socket.socket) -> list[bytes]:
    found = []
    try:
        while True:
            found.append(listener.recv(65536))
    except TimeoutError:
        return found


@pytest.mark.parametrize("packed", [False, True])
def test_live_publishes_each_frame_as_a_datagram(tmp_path: Path, listener: socket.socket, packed: bool) -> None:
    scene = grip(0.3)
    description = emulated_description("native", scene)
    array, port = write_array(tmp_path, description.text), listener.getsockname()[1]
    words = ["--publish", f"udp://127.0.0.1:{port}", "--every-frame", "--tare", "off", "--once", "--seconds", "20"]
    with device(packets(description, scene)) as emulator:
        live = call("live", "-p", emulator.port, "-a", array, *words, *(["--msgpack"] if packed else []))
    assert live.exit_code == 0, live.output
    printed = [json.loads(line) for line in lines(live.stdout, "frame")]
    datagrams = received(listener)
    assert len(printed) == len(datagrams) == 120
    (end,) = (json.loads(line) for line in lines(live.stdout, "end"))
    assert end["published"] == {"sent": 120, "unsent": 0}
    assert {"latency_median_s", "latency_p99_s"} <= set(end["latency"])
    for line, datagram, frame in zip(printed, datagrams, scene, strict=True):
        got = msgpack.unpackb(datagram) if packed else json.loads(datagram)
        if packed:
            values = np.frombuffer(got["values"], "<f4").reshape(got.pop("shape"))
            assert np.allclose(values, line["values"], rtol=1e-7, atol=0)
            got["values"] = line["values"]
        assert got == line
        assert np.allclose(line["values"], frame.values, atol=1e-7)
        assert (line["finger"], line["sequence"]) == (scene.arrays[frame.finger].name, frame.sequence)
        assert abs(line["unix_s"] - line["t_s"] - printed[0]["unix_s"] + printed[0]["t_s"]) < 1e-3
    begun = [event["words"] for line in printed for event in line["begun"]]
    assert begun == [json.loads(line)["words"] for line in lines(live.stdout, "event")]
    assert sum("contact on" in words for words in begun) == 2


def test_wrong_addresses_and_arrays_are_refused(tmp_path: Path) -> None:
    assert udp_address("udp://:9000") == udp_address("udp://127.0.0.1:9000") == ("127.0.0.1", 9000)
    assert udp_address("udp://[::1]:9000") == ("::1", 9000)
    for wrong in ("tcp://127.0.0.1:9000", "udp://127.0.0.1", "9000", "udp://127.0.0.1:99999", "udp://h:1/x", ""):
        with pytest.raises(InputError, match="udp://HOST:PORT wanted"):
            udp_address(wrong)
    large = TaxelArray("a", 40, 40, 0.001, 0.0, quantity="force")
    with pytest.raises(InputError, match=r"40 x 40 taxels takes \d+ bytes, a datagram 65507; --msgpack"):
        Publisher("udp://:9", (large,))
    Publisher("udp://:9", (large,), packed=True).close()
    array = write_array(tmp_path, emulated_description("native", grip(0.1)).text)
    alone = call("live", "-p", "x", "-a", array, "--msgpack")
    assert alone.exit_code == 2
    assert "--msgpack is the format of --publish" in alone.stderr


def test_commands_name_the_missing_extra_in_one_line(tmp_path: Path, recording: Path) -> None:
    convert(recording, tmp_path / "x.mcap")
    code = """
import sys
for name in ("serial", "cobs", "mcap", "pyarrow", "rosbags", "lz4", "zstandard", "msgpack"):
    sys.modules[name] = None
from click.testing import CliRunner
from tactile.cli.group import main
for line in sys.argv[1:]:
    done = CliRunner().invoke(main, line.split())
    print(done.exit_code, done.output.count(chr(10)), "which is not installed: pip install" in done.output)
"""
    given = ["live -p x --protocol papillarray", "record -p x --protocol papillarray -o y.mcap", "replay x.mcap",
             "emulate --recording x.mcap", "run x.mcap", "ports"]  # fmt: skip
    environment = {"PYTHONPATH": str(ROOT), "PATH": ""}
    done = subprocess.run(
        [sys.executable, "-c", code, *given], cwd=tmp_path, env=environment, capture_output=True, text=True, check=True
    )
    assert done.stdout.splitlines() == ["2 1 True"] * len(given), done.stdout
