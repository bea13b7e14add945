"""Firmware: the C header, the sketch and the CircuitPython file send what the native decoder reads, to the bit."""

import os
import re
import shutil
import subprocess
import tty
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from tactile.events.event import EventLog
from tactile.pipeline import run
from tactile.settings import Settings
from tactile.wire.base import Options
from tactile.wire.description import Description
from tactile.wire.description_file import parse_description, read_description
from tactile.wire.firmware import firmware
from tactile.wire.registry import find_format
from tactile.wire.source import Chunk, WireSource
from tests.kits.paths import ROOT
from tests.kits.serial import call, write_array

FIRMWARE = ROOT / "examples" / "firmware"
SENDER = """
#include <stdio.h>
#include <stdlib.h>
#include "tactile_native.h"
/* board rows cols kind sequence; standard input: u32 time, values; standard output: frames */
int main(int count, char **word) {
  static uint8_t out[TACTILE_FRAME_SIZE(64u, float)];
  static float values[64 * 3];
  uint64_t clock = 0;
  uint32_t now;
  (void)count;
  tactile_board board = {(uint8_t)atoi(word[1]), (uint8_t)atoi(word[2]), (uint8_t)atoi(word[3]),
                         (uint32_t)strtoul(word[5], 0, 10)};
  int kind = atoi(word[4]);
  size_t size = 3u * board.rows * board.cols * (kind ? sizeof(float) : sizeof(int16_t));
  while (fread(&now, 4, 1, stdin) == 1 && fread(values, size, 1, stdin) == 1) {
    uint64_t time = tactile_time(&clock, now);
    size_t length = kind ? tactile_encode_float32(&board, values, time, out)
                         : tactile_encode_int16(&board, (const int16_t *)values, time, out);
    fwrite(out, 1, length, stdout);
  }
  return 0;
}
"""
ARDUINO = """
#include <cstdint>
#include <cstdio>
static uint32_t now = 0xFFFFFFFFu - 1000000u;
static uint32_t micros() { return now += 2500; }
struct { void begin(uint32_t) {} void write(uint8_t byte) { putchar(byte); }
         void write(const uint8_t *data, size_t size) { fwrite(data, 1, size, stdout); }
         operator bool() { return true; } } Serial;
#include "board.ino"
int main() { setup(); for (int n = 0; n < 4 * 240; n++) loop(); }
"""


def compiled(tmp_path: Path, compiler: str, source: str, *options: str) -> Path:
    if shutil.which(compiler) is None:
        pytest.skip(f"no {compiler} on this system")
    file = tmp_path / ("main.c" if compiler == "cc" else "main.cpp")
    file.write_text(source)
    strict = ("-Wall", "-Wextra", "-Werror", "-pedantic", "-O1")
    subprocess.run([compiler, *options, *strict, "-o", tmp_path / "main", file], check=True)
    return tmp_path / "main"


def sent_through_a_pty(program: Path, *words: Any, data: bytes = b"") -> bytes:
    master, slave = os.openpty()
    tty.setraw(slave)
    (file := program.with_name("input")).write_bytes(data)
    with file.open("rb") as given:
        process = subprocess.Popen([program, *map(str, words)], stdin=given, stdout=slave)
    os.close(slave)
    got = b""
    while True:
        try:
            part = os.read(master, 65536)
        except OSError:  # the last program with the port open has ended
            break
        if not part:
            break
        got += part
    os.close(master)
    assert process.wait() == 0
    return got


def test_the_header_sends_every_frame_to_the_bit_over_wraps_of_sequence_and_time(tmp_path: Path) -> None:
    program = compiled(tmp_path, "cc", SENDER, "-std=c99", f"-I{FIRMWARE}")
    rng, first, count = np.random.default_rng(3), 2**32 - 5, 40
    micros = np.cumsum(rng.integers(1, 2**31, count))  # wraps of 32 bits in every second or third frame
    for board, shape, kind in ((0, (8, 8), 0), (1, (8, 8), 1), (2, (2, 2), 0), (0, (2, 2), 1)):
        values = rng.integers(-(2**15), 2**15, (count, shape[0] * shape[1], 3)).astype(("<i2", "<f4")[kind])
        values[::3] *= rng.random(values[::3].shape) < 0.1  # long runs of zeros
        values[1::4] = 0x0101  # and none in more than 254 bytes
        if kind:
            values[2, 0, 0], values[2, 1] = np.nan, (np.inf, -0.0, 1e-45)
        data = b"".join(
            int(t % 2**32).to_bytes(4, "little") + one.tobytes() for t, one in zip(micros, values, strict=True)
        )
        got = sent_through_a_pty(program, board, *shape, kind, first, data=data)
        native, options = find_format("native"), Options((shape,) * 3, {"value": ("int16", "float32")[kind]})
        decoder, encoder = native.decoder(options), native.encoder(options)
        readings = decoder.feed(got)
        assert len(readings) == decoder.counts.good == count
        assert decoder.counts.missing == decoder.counts.bad_checksum == decoder.counts.resynchronised == 0
        for n, one in enumerate(readings):
            assert (one.device, one.sequence) == (board, (first + n) % 2**32)
            assert round(one.t_device * 1e6) == micros[n]
            assert one.values.astype(values.dtype).tobytes() == values[n].tobytes()
        ours = b"".join(encoder.encode([one] * 3, first + n, micros[n] * 1e-6) for n, one in enumerate(values))
        frames = [frame + b"\0" for frame in ours.split(b"\0")[:-1]]
        assert got == b"".join(frames[board::3])


def events_of(description: Description, data: bytes) -> list[tuple[str, str]]:
    frames = [frame + b"\0" for frame in data.split(b"\0")[:-1]]
    chunks = [Chunk(n // len(description.arrays) * 10**7, frame) for n, frame in enumerate(frames)]
    log, source = EventLog(), WireSource(description, chunks)
    run(source, Settings(tare="auto"), [lambda report: log.add(report.events, report.ended)])
    assert source.counts.missing == source.counts.bad_checksum == source.counts.unfit == 0
    return [(event.kind, event.finger) for event in log.events]


def test_the_sketch_for_an_array_file_gives_events_before_it_is_filled_in(tmp_path: Path) -> None:
    done = call("new", "firmware", "board", "-a", FIRMWARE / "array.toml", "-o", tmp_path)
    assert done.exit_code == 0, done.output
    program = compiled(tmp_path, "c++", ARDUINO, "-std=c++11", f"-I{tmp_path / 'board'}")
    data = subprocess.run([program], capture_output=True, check=True).stdout
    found = events_of(read_description(FIRMWARE / "array.toml"), data)
    assert [finger for kind, finger in found if kind == "contact"] == ["finger", "palm"]
    assert [finger for kind, finger in found if kind == "release"] == ["finger", "palm"]


ANALOG = """
static const int A0 = 14, OUTPUT = 1;
static uint8_t pins[16], modes[16];
static void pinMode(int pin, int mode) { modes[pin] = (uint8_t)mode; }
static void digitalWrite(int pin, int level) { if (modes[pin] == OUTPUT) pins[pin] = (uint8_t)level; }
static void delayMicroseconds(unsigned) {}
static int analogRead(int pin) {
  int row = pins[2] + 2 * pins[3] + 4 * pins[4], col = pins[5] + 2 * pins[6] + 4 * pins[7];
  return 100 * row + 10 * col + (pin - A0);
}
"""


def test_the_code_of_the_page_reads_each_taxel_of_an_array(tmp_path: Path) -> None:
    text = (ROOT / "docs" / "connect-a-board.md").read_text(encoding="utf-8")
    (block,) = re.findall(r"```cpp\n(.*?)```", text, re.DOTALL)
    for name, content in firmware(read_description(FIRMWARE / "array.toml"), "board").items():
        made = re.sub(r"void read_taxels\(.*?\n}\n", lambda _: block, content, flags=re.DOTALL)
        assert name != "board.ino" or made != content
        (tmp_path / name).write_text(made)
    program = compiled(tmp_path, "c++", ARDUINO.replace("#include \"board.ino\"", ANALOG + "#include \"board.ino\""),
                       "-std=c++11", f"-I{tmp_path}")  # fmt: skip
    data = subprocess.run([program], capture_output=True, check=True).stdout
    decoder = find_format("native").decoder(Options(((2, 2), (8, 8))))
    for reading in decoder.feed(data)[:4]:
        side = (2, 8)[reading.device or 0]
        row, col, axis = np.meshgrid(np.arange(side), np.arange(side), np.arange(3), indexing="ij")
        assert np.array_equal(reading.values, (100 * row + 10 * col + axis).reshape(-1, 3))


def test_replace_keeps_what_the_user_has_filled_in(tmp_path: Path) -> None:
    words = "new", "firmware", "board", "-a", FIRMWARE / "array.toml", "-o", tmp_path
    assert call(*words).exit_code == 0
    sketch, code = tmp_path / "board" / "board.ino", tmp_path / "board" / "code.py"
    for path in (sketch, code):
        path.write_text(path.read_text().replace("FILL IN", "my own sensors"))
    assert call(*words).exit_code == 2
    done = call(*words, "--rate-hz", "250", "--replace")
    assert done.exit_code == 0, done.output
    assert "board.ino and code.py: the configuration is new, the rest is kept" in done.output
    assert "RATE_HZ = 250, BAUDRATE" in sketch.read_text()
    assert "RATE_HZ = 250\n" in code.read_text()
    assert all("my own sensors" in path.read_text() for path in (sketch, code))
    code.write_text("my own program")
    refused = call(*words, "--replace")
    assert refused.exit_code == 2
    assert "code.py: no lines 'begin of the configuration'" in refused.stderr
    assert code.read_text() == "my own program"


OWN = """
protocol = "native"
[[finger]]
name = "a"
rows = 2
cols = 3
pitch_mm = 3.0
depth_mm = 0.0
quantity = "force"
axes = ["z", "-y", "-x"]
cells = [[0, 1, 2], [-1, 3, 4]]
"""


def test_the_circuitpython_file_sends_what_the_encoder_does(tmp_path: Path) -> None:
    for gains, kind in (("", "float32"), ("gains = [0.25, -0.5]\n", "int16"), ("gains = [1e-9, 1e-9]\n", "float32")):
        description = parse_description(OWN + gains, "array")
        module: dict[str, Any] = {"__name__": "code"}
        exec(firmware(description, "board", 250)["code.py"], module)
        assert module["RATE_HZ"] == 250
        assert module["FINGERS"][0][:2] == (1, 5)  # five chips, as the wire has them
        native, options = find_format("native"), Options(((1, 5),), {"value": kind})
        touched = module["read_taxels"](0, 3.5)
        for values in ([0] * 15, list(range(15)), [300] * 15, touched):
            ours = native.encoder(options).encode([np.array(values).reshape(5, 3)], 2**32 + 7, 5.000001)
            assert bytes(module["encode"](0, 2**32 + 7, 5_000_001, values)) == ours
        source = WireSource(description, [Chunk(0, bytes(module["encode"](0, 0, 0, touched)))])
        (frame,) = source
        assert np.allclose(frame.values[frame.valid], [0, 0, 1.0], rtol=1e-6)


def test_the_shipped_files_are_those_of_the_shipped_array_and_other_protocols_are_refused(tmp_path: Path) -> None:
    made = firmware(read_description(FIRMWARE / "array.toml"), "firmware")
    for name, text in made.items():
        shipped = FIRMWARE / ("circuitpython.py" if name == "code.py" else name)
        assert text == shipped.read_text(encoding="utf-8"), name
    assert len(made["tactile_native.h"].splitlines()) <= 200
    array = write_array(tmp_path, OWN.replace("native", "csv"))
    for words, message in (
        (("-a", array), "protocol 'csv'; native wanted"), ((), "--array FILE of the board wanted"),
        (("no/name", "-a", FIRMWARE / "array.toml"), "letters, digits"),
    ):  # fmt: skip
        refused = call("new", "firmware", *words, "-o", tmp_path)
        assert refused.exit_code == 2
        assert message in refused.stderr
    assert call("new", "scene").exit_code == call("new", "scene", "x", "-a", array).exit_code == 2
