"""The live array view on a port: every frame is recorded, the tare is requested, and the page's server is guarded."""

import json
import re
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest

pytest.importorskip("serial", reason="needs the extra serial")
pytest.importorskip("mcap", reason="needs the extra serial")

from cnnsim.studio.message import unpack
from tactile.live_options import LiveOptions
from tactile.recording.reader import open_recording
from tactile.serial.emulator import Emulator
from tactile.studio import PAGE
from tactile.studio.model import ArrayModel
from tactile.studio.port_link import PortLink
from tactile.wire.description import Description
from tactile.wire.description_file import read_description
from tests.fuzz.two_ends import emulator, metronome
from tests.kits.browser import opened
from tests.kits.processes import wait_until
from tests.kits.serial import call, device, sent
from tests.kits.studio import Visitor, serving
from tests.tactile.studio.conftest import Known
from tests.tactile.studio.test_model import ask

PAUSE = 0.02
"""[s] Pause of the whole machine from which the emulated device may lose packets itself, half of its buffer."""


@contextmanager
def connected(emulated: Emulator, description: Description, output: Path) -> Iterator[PortLink]:
    link = PortLink(emulated.port, description, LiveOptions(), output)
    link.feed.start()
    try:
        yield link
    finally:
        link.close()


def test_a_port_is_shown_tared_and_recorded_twice(tmp_path: Path) -> None:
    description, stream = sent("native", 1.5)
    with device(stream) as one, connected(one, description, tmp_path / "a.mcap") as link:
        model = ArrayModel(link.feed, link)
        assert "a.mcap" in ask(model, "record", on=True).content["text"]
        wait_until(lambda: bool(link.feed.times and link.feed.times[1] > 0.5))
        assert ask(model, "frame").content["status"]["recording"] == "a.mcap"
        ask(model, "tare", force=True)
        frames = 2 * len(stream)  # a packet has both fingers
        wait_until(lambda: link.session.counts.good == frames)
        status = ask(model, "frame").content["status"]
        assert "left: by force" in status["answer"]
        assert f"{frames} good, 0 bad checksum" in status["losses"]
        assert "frames/s" in status["rate"]
        assert "a.mcap" in ask(model, "record", on=False).content["text"]
        said = ask(model, "record", on=True).content
        assert said["warning"] == said["text"].startswith("in contact: a replay takes its tare")
        assert said["warning"] == any(one.report.code.contact.any() for one in link.feed.at(99.0) if one)
        assert ask(model, "frame").content["status"]["recording"] == "a-2.mcap"
    recorded = open_recording(tmp_path / "a.mcap")
    assert recorded.complete
    assert recorded.counts is not None
    assert recorded.counts["counts"]["good"] == frames
    assert [note["note"] for note in recorded.notes("/port")].count("tare by force") == 1
    assert sum(1 for _ in recorded.source()) == frames
    assert open_recording(tmp_path / "a-2.mcap").complete


def test_the_guards_of_the_playground_hold_here_too(known: Known) -> None:
    with serving(lambda: ArrayModel(known.feed), page=PAGE) as address:
        stranger, one = Visitor(address), Visitor(address)
        assert stranger.request("/page/live.js")[0] == 403
        one.enter()
        assert one.request("/", Host=f"evil.example:{one.host.rsplit(':', 1)[1]}")[0] == 421
        assert one.request("/", "POST", Origin="http://evil.example")[0] == 403
        assert b"tactile studio" in one.request("/")[2]
        assert one.request("/page/live.js")[0] == one.request("/page/base.js")[0] == 200
        assert one.request("/page/../model.py")[0] == 404
        with one.socket() as socket:
            for data in ("{", '{"do": "frame", "t": NaN}', '{"do": "thresholds", "sigmas": {}}', b"\xff\xff\xff\xff"):
                socket.send(data)
                assert json.loads(socket.recv())["is"] == "error"
            socket.send('{"do": "frame", "t": 3}')
            assert unpack(socket.recv()).content["t"] == 3


@pytest.mark.parametrize(
    ("words", "message"),
    [(["studio", "/dev/nothing"], "--array or --protocol wanted"), (["studio", "nothing.toml"], "nothing.toml"),
     (["studio", "grip.toml", "--record", "a.mcap"], "for ports"),
     (["studio", "/dev/nothing", "--layout", "x.toml"], "no file /dev/nothing"),
     (["studio", "/dev/nothing", "--protocol", "native"], "array")],
    ids=lambda value: " ".join(value) if isinstance(value, list) else "",
)  # fmt: skip
def test_a_source_that_cannot_be_shown_is_one_line(words: list[str], message: str) -> None:
    result = call(*words)
    assert result.exit_code == 2
    assert message in result.output + result.stderr


@pytest.mark.slow
def test_no_frame_is_lost_at_1000_a_second_while_a_page_is_open(tmp_path: Path) -> None:
    with emulator(tmp_path, 1000, 4, fingers=2) as end, metronome() as longest_pause:
        description = read_description(tmp_path / "array.toml")
        link = PortLink(str(tmp_path / "skin"), description, LiveOptions(), tmp_path / "a.mcap")
        link.record(True)
        link.feed.start()
        with (
            serving(lambda: ArrayModel(link.feed, link), page=PAGE) as address,
            opened(address, tmp_path / "profile") as page,
        ):
            page.until("document.querySelector('#record').textContent", "■ Stop a.mcap")
            page.until("Number(document.body.dataset.t) > 3.9")
            page.page.click("#tare")
            page.until("document.querySelector('#summary').textContent.includes('tare ')")  # requested, then the answer
            page.until("!document.querySelector('#state').textContent.endsWith('open')")  # its frames have ended
            said = end()
            page.page.click("#record")
            page.until("document.querySelector('#record').textContent", "● Record")
            assert page.page.is_disabled("#record")
            assert page.text("#summary").startswith("the port is lost: ")
            assert not page.console
        link.close()
    sent, lost = map(int, re.findall(r"\d+", said))
    recorded = open_recording(tmp_path / "a.mcap")
    assert recorded.complete
    assert lost == 0 or longest_pause() > PAUSE
    for finger in (0, 1):
        sequences = [frame.sequence for frame in recorded.source() if frame.finger == finger]
        assert sequences[-1] == sent - 1
        assert len(sequences) + lost >= sent - sequences[0] > 3000  # what came before the port was read is discarded
