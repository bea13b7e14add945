"""`tactile live --calibration`: gains from the calibration, which is stored in the recording."""

import json
from pathlib import Path
from typing import Any

import pytest

from tactile.calibration.file import Calibration, write_calibration
from tactile.calibration.gains import Gains
from tactile.calibration.radial import RadialCorrection
from tactile.cli.port.live import LiveMonitor
from tactile.live_options import LiveOptions
from tactile.recording.reader import open_recording
from tactile.wire.packets import emulated_description, packets
from tactile.wire.source import WireSource
from tests.kits.serial import call, device, grip, later, lines, write_array


def test_a_calibration_replaces_the_gains_and_is_stored_for_the_replay(tmp_path: Path) -> None:
    """The events are those of the same gains in the description; the radial factor 2 doubles the force."""
    scene = later(grip(2.2), 0.7)
    description = emulated_description("reskin", scene)
    bare = "\n".join(line for line in description.text.splitlines() if not line.startswith("gains"))
    array, mcap, skin = write_array(tmp_path, bare), tmp_path / "r.mcap", tmp_path / "skin.toml"
    gains = description.boards[0].gains
    assert gains is not None
    write_calibration(skin, Calibration(gains, scene.arrays[0].depth, RadialCorrection((0, 1), (0, 1), (2, 2))))
    with device(list(packets(description, scene))) as emulator:
        live = call("live", "-p", emulator.port, "-a", array, "--record", mcap, "--json", "--once", "--seconds", "20",
                    "--calibration", skin)  # fmt: skip
    assert live.exit_code == 0, live.output
    skin.unlink()
    replayed = call("replay", mcap, "--json")
    assert lines(replayed.stdout, "event") == lines(live.stdout, "event")
    assert lines(replayed.stdout, "tare") == lines(live.stdout, "tare")

    output: list[dict[str, Any]] = []
    LiveMonitor(WireSource(description, open_recording(mcap).chunks()), output.append).run(LiveOptions())
    events = [line for line in output if line["type"] == "event" and not line["kind"].startswith("tangential")]
    live_events = [json.loads(line) for line in lines(live.stdout, "event")]
    live_events = [
        line for line in live_events if not line["kind"].startswith("tangential")
    ]  # their threshold applies to the doubled force
    assert len(events) >= 10
    same = "finger", "kind", "t_s", "sequence"
    assert [[line[name] for name in same] for line in live_events] == [[line[name] for name in same] for line in events]
    for one, other in zip(live_events, events, strict=True):
        assert (one["load"] is None) == (other["load"] is None)
        if other["load"] is not None:
            x, y, force = (other["load"][name] for name in ("x", "y", "F"))
            assert [one["load"][name] for name in ("x", "y", "F")] == pytest.approx((x, y, 2 * force), rel=1e-6)


def test_wrong_calibrations_are_refused(tmp_path: Path) -> None:
    skin = tmp_path / "skin.toml"
    for text, message in (("", "'radial'"), (None, "no calibration")):
        if text is not None:
            skin.write_text(text, encoding="utf-8")
        result = call("live", "-p", "x", "--protocol", "papillarray", "--calibration", skin)
        assert result.exit_code == 2
        assert message in result.stderr
        skin.unlink(missing_ok=True)
    write_calibration(skin, Calibration(Gains(1, 1), 1e-3, RadialCorrection((0, 1), (0, 1), (1, 1))))
    result = call("live", "-p", "x", "--protocol", "papillarray", "--calibration", skin)
    assert result.exit_code == 2
    assert "array 'sensor-0' of force; strain wanted" in result.stderr
    assert "note: no --array: the arrays of papillarray are supposed to be sensor-0 of 3 x 3 at 7 mm" in result.stderr
