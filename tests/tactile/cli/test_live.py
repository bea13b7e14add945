"""`tactile live`, `record`, `replay` and `emulate`: the same events live and replayed, tares, errors."""

import json
import os
import threading
from functools import partial
from pathlib import Path
from typing import Any

import pytest

from tactile.cli.port.live import LiveMonitor
from tactile.live_options import LiveOptions
from tactile.recording.reader import open_recording
from tactile.recording.writer import Recording
from tactile.serial.session import Session
from tactile.wire.packets import emulated_description, packets
from tests.kits.processes import wait_until
from tests.kits.serial import GRIP, call, device, grip, later, lines, sent, write_array

LIMIT = "20"


@pytest.mark.parametrize(("protocol", "tare"), [("native", "off"), ("native", "auto"), ("reskin", "off")])
def test_replay_gives_the_live_events_byte_for_byte(tmp_path: Path, protocol: str, tare: str) -> None:
    """The grip from its first contact on; with a tare, 0.5 s without contact before."""
    scene = grip(1.6) if tare == "off" else later(grip(2.2), 0.7)
    description = emulated_description(protocol, scene)
    array, mcap = write_array(tmp_path, description.text), tmp_path / "r.mcap"
    with device(list(packets(description, scene))) as emulator:
        live = call("live", "-p", emulator.port, "-a", array, "--record", mcap, "--json", "--tare", tare, "--once",
                    "--seconds", LIMIT)  # fmt: skip
    assert live.exit_code == 0, live.output
    events = lines(live.stdout, "event")
    happened = [(event["kind"], event["data"].get("direction")) for event in map(json.loads, events)]
    assert happened.count(("contact", None)) == 2
    assert ("tangential_load", "+y") in happened
    replayed = call("replay", mcap, "--json")
    assert lines(replayed.stdout, "event") == events
    assert lines(replayed.stdout, "tare") == lines(live.stdout, "tare")
    ran = call("run", mcap, "-o", tmp_path / "out", "--tare", tare)
    assert ran.exit_code == 0, ran.output
    record = json.loads((tmp_path / "out" / "events.json").read_text(encoding="utf-8"))
    assert sorted(map(key, record["events"])) == sorted(map(key, map(json.loads, events)))
    assert len(lines(live.stdout, "tare")) == (0 if tare == "off" else 4)  # at the start and idle
    (end,) = (json.loads(line) for line in lines(live.stdout, "end"))
    assert end["counts"]["good"] == (2 if protocol == "native" else 1) * round(200 * scene.duration)
    recorded = open_recording(mcap)
    assert [
        json.dumps(event, ensure_ascii=False) for event in recorded.notes("/events") if event["type"] == "event"
    ] == events
    assert recorded.counts is not None
    assert recorded.counts["counts"] == end["counts"]
    assert json.loads(recorded.made["choices"])["tare"] == tare
    (last,) = (json.loads(line) for line in lines(replayed.stdout, "end"))
    assert last["complete"] is True
    assert last["counts"] == end["counts"]


def key(event: dict[str, Any]) -> tuple[Any, ...]:
    return event["t_s"], event["finger"], event["kind"], event["ternary"], json.dumps(event["data"], sort_keys=True)


def test_live_and_replay_print_text(tmp_path: Path) -> None:
    description, stream = sent("native", 0.6)
    array, mcap = write_array(tmp_path, description.text), tmp_path / "r.mcap"
    with device(stream) as emulator:
        live = call("live", "-p", emulator.port, "-a", array, "--record", mcap, "--tare", "off", "--once")
    assert live.exit_code == 0, live.output
    assert "  left  contact" in live.stdout
    assert "240 good, 0 bad checksum" in live.stdout
    assert "events; latency" in live.stdout
    assert "device: +0.0 ppm" in live.stdout
    replayed = call("replay", mcap)
    assert "  left  contact" in replayed.stdout
    assert "240 frames" in replayed.stdout


def test_record_stores_bytes_and_frames(tmp_path: Path) -> None:
    description, stream = sent("papillarray", 0.3)
    array, mcap = write_array(tmp_path, description.text), tmp_path / "r.mcap"
    with device(stream) as emulator:
        result = call("record", "-p", emulator.port, "-a", array, "-o", mcap, "--once")
    assert result.exit_code == 0, result.output
    assert "recorded: 60 good" in result.stdout
    assert "slip entry type bytes: 2" in result.stdout
    again = open_recording(mcap)
    assert again.messages["/wire"] >= 1
    assert again.messages["/frames/left"] == again.messages["/frames/right"] == 60


def test_a_requested_tare_is_recorded_and_replayed_at_the_same_frame(tmp_path: Path) -> None:
    scene = later(grip(1.5), 9.0)
    description = emulated_description("native", scene)
    mcap = tmp_path / "r.mcap"
    choices = LiveOptions(tare="manual")
    into = partial(Recording, mcap, description, {"choices": choices.text()})
    output: list[dict[str, Any]] = []
    with device(list(packets(description, scene))) as emulator:
        session = Session(emulator.port, description, into, seconds=20)
        assert session.recording is not None
        asked = False

        def look(line: dict[str, Any]) -> None:
            nonlocal asked
            output.append(line)
            if line["type"] == "tare" and not asked:
                session.reader.ask_tare()
                asked = True
            elif line["type"] == "tare" and line["why"] == "on request":
                session.stop()

        watch = LiveMonitor(session.source, look, session.now, session.recording.note)
        watch.run(choices)
        session.recording.close({})
    tares = [line for line in output if line["type"] == "tare"]
    assert [line["why"] for line in tares if line["finger"] == "left"] == ["at the start", "on request"]
    replayed = call("replay", mcap, "--json")
    assert [json.loads(line) for line in lines(replayed.stdout, "tare")] == tares
    assert [note["note"] for note in open_recording(mcap).notes("/port")][:2] == ["plugged", "tare"]


def test_wrong_arguments_are_refused_in_one_line(tmp_path: Path) -> None:
    description, stream = sent("reskin", 0.1)
    array = write_array(tmp_path, description.text)
    bare = tmp_path / "bare.toml"
    bare.write_text("\n".join(line for line in description.text.splitlines() if not line.startswith("gains")))
    for arguments, message in (
        (("live", "-p", tmp_path / "none", "-a", array), "there is no such port"),
        (("live", "-p", "x", "-a", bare), "gains = [shear, normal] per uT wanted"),
        (("live", "-p", "x"), "--array or --protocol wanted"),
        (("live", "-p", "x", "-a", array, "--protocol", "csv"), "says reskin"),
        (("live", "-p", "x", "--protocol", "reskin"), "--array FILE wanted"),
        (("live", "-p", "x", "-a", array, "--hysteresis", "1"), "hysteresis needs a dead_band"),
        (("live", "-p", "x", "-a", array, "--sign-code", "--dead-band", "1"), "--sign-code has no dead band"),
        (("record", "-p", "x", "-a", array, "-o", tmp_path / "r.bag"), ".mcap wanted"),
        (("record", "-p", "x", "-a", tmp_path / "no.toml", "-o", tmp_path / "r.mcap"), "no array description"),
        (("replay", tmp_path / "none.mcap"), "cannot be read"),
        (("emulate", "--protocol", "csv"), "either --scene or --recording wanted"),
        (("emulate", "--scene", GRIP), "--protocol or --array wanted"),
        (("emulate", "--scene", GRIP, "--protocol", "csv", "--drop", "2"), "drop = 2.0"),
        (("emulate", "--scene", GRIP, "--protocol", "paxini-serial"), "carries one array"),
    ):
        result = call(*arguments)
        assert result.exit_code == 2, (arguments, result.output)
        assert message in result.stderr
        assert "Traceback" not in result.output
    with device(stream) as emulator:
        session = Session(emulator.port, description, seconds=20)
        second = call("record", "-p", emulator.port, "-a", array, "-o", tmp_path / "r.mcap")
        session.stop()
        list(session.source)
    assert second.exit_code == 2
    assert "another reader has it open" in second.stderr
    assert not (tmp_path / "r.mcap").exists()


def test_a_program_runs_in_live_and_in_the_replay(tmp_path: Path) -> None:
    """contact-blob on the grip: four taxels in contact are a blob of area 4."""
    description, stream = sent("native", 0.4)
    array, mcap = write_array(tmp_path, description.text), tmp_path / "r.mcap"
    with device(stream) as emulator:
        live = call("live", "-p", emulator.port, "-a", array, "--record", mcap, "--json", "--tare", "off", "--once",
                    "--program", "contact-blob", "--backend", "reference")  # fmt: skip
    assert live.exit_code == 0, live.output
    outputs = [json.loads(line) for line in lines(live.stdout, "program")]
    assert {line["finger"] for line in outputs} == {"left", "right"}
    assert outputs[0]["outputs"]["area"] == 0
    assert outputs[-1]["outputs"]["contact"] == [[1, 1], [1, 1]]
    assert outputs[-1]["outputs"]["area"] == 4
    replayed = call("replay", mcap, "--json")
    assert [json.loads(line) for line in lines(replayed.stdout, "program")] == outputs
    wrong = call("live", "-p", "x", "-a", array, "--program", "median")
    assert (wrong.exit_code, "inputs picture; of right, left" in wrong.stderr) == (2, True)


def test_a_recording_can_be_emulated(tmp_path: Path) -> None:
    """The bytes of a recording are sent over a terminal and recorded again."""
    description, stream = sent("csv", 0.3)
    array, first, second = write_array(tmp_path, description.text), tmp_path / "1.mcap", tmp_path / "2.mcap"
    with device(stream) as emulator:
        call("record", "-p", emulator.port, "-a", array, "-o", first, "--once")
    link, results = tmp_path / "skin", []
    thread = threading.Thread(target=lambda: results.append(call("emulate", "--recording", first, "--link", link)))
    thread.start()
    wait_until(lambda: os.path.lexists(link))
    again = call("record", "-p", link, "-a", array, "-o", second, "--once")
    thread.join()
    assert (again.exit_code, results[0].exit_code) == (0, 0), again.output + results[0].output
    one, two = (b"".join(chunk.data for chunk in open_recording(path).chunks()) for path in (first, second))
    assert one == two == b"".join(data for _, data in stream)
