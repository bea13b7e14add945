"""Warnings within three seconds about silence, another protocol or another shape."""

import json
import time
from pathlib import Path
from typing import Any

import pytest
from click.testing import Result

from tactile.serial import port_check, session
from tactile.wire.description import Description
from tactile.wire.description_file import parse_description
from tactile.wire.packets import packets
from tests.kits.serial import call, device, grip, sent, write_array


def described(protocol: str, rows: int, cols: int, fingers: int = 1) -> Description:
    text = f'protocol = "{protocol}"\nyoungs_modulus_mpa = 0.4\n'
    for n in range(fingers):
        text += f'[[finger]]\nname = "f{n}"\nrows = {rows}\ncols = {cols}\npitch_mm = 1.0\ndepth_mm = 1.0\n'
        text += 'quantity = "strain"\n'
    return parse_description(text, "test")


@pytest.fixture
def short_patience(monkeypatch: pytest.MonkeyPatch) -> None:
    assert port_check.PATIENCE + 2 * session.NAP < 3.0
    monkeypatch.setattr(port_check, "PATIENCE", 0.8)


@pytest.mark.usefixtures("short_patience")
@pytest.mark.parametrize(("sending", "reading", "message"), [
    ("native", described("native", 3, 3, 2), "than described (3 x 3, 3 x 3 taxels): board"),
    ("native", described("lowiek", 4, 8), "no frame of lowiek in them: another protocol, baud rate (400000)"),
    ("csv", described("csv", 3, 3), "whole frames of csv are of another shape than described (3 x 3 taxels): 26"),
    ("reskin", described("reskin", 1, 5), "bytes belong to no frame of reskin: the device has another number of"),
    ("reskin", described("native", 2, 2), "no frame of native in them"),
])  # fmt: skip
def test_a_stream_that_does_not_match_the_description_is_reported(
    sending: str, reading: Description, message: str
) -> None:
    description, _ = sent(sending, 0.1)
    warnings: list[str] = []
    with device(packets(description, grip(4.0), loop=True)) as emulator:

        def warn(text: str) -> None:
            warnings.append(text)
            running.stop()

        running = session.Session(emulator.port, reading, seconds=6, warn=warn)
        for _ in running.source:
            pass
    assert len(warnings) == 1
    assert message in warnings[0]


@pytest.mark.usefixtures("short_patience")
def test_silence_is_reported_and_a_matching_stream_is_not(tmp_path: Path) -> None:
    description, _ = sent("native", 0.1)
    array = write_array(tmp_path, description.text)

    def silent(seconds: float) -> Any:
        time.sleep(seconds)
        yield 0.0, b""

    def record(name: str, *more: str) -> Result:
        return call("record", "-p", emulator.port, "-a", array, "-o", tmp_path / name, *more)

    with device(silent(1.5)) as emulator:
        result = record("r.mcap", "--seconds", "1.4", "--json")
    texts = [json.loads(line)["text"] for line in result.stdout.splitlines() if '"warning"' in line]
    assert len(texts) == 1
    assert "is open, but nothing comes: is the device on" in texts[0]
    with device(silent(0.5)) as emulator:
        result = record("s.mcap", "--seconds", "0.3")
    assert result.stderr.count("warning: port") == 1  # at the latest at the end
    with device(packets(description, grip(4.0), loop=True)) as emulator:
        result = record("t.mcap", "--seconds", "1.6")
    assert result.stderr == ""
