"""Thresholds of the array file and the command line in live, replay, run and converted recordings."""

import json
from pathlib import Path
from typing import Any

from click.testing import Result

from tactile.wire.description_file import read_description
from tests.kits.serial import call, device, lines, sent, write_array


def events(done: Result, *, as_lines: bool = False) -> list[tuple[Any, ...]]:
    assert done.exit_code == 0, done.output
    found = map(json.loads, lines(done.stdout, "event")) if as_lines else json.loads(done.stdout)["events"]
    return sorted((one["t_s"], one["finger"], one["kind"], one["ternary"]) for one in found)


def test_thresholds_are_stored_with_the_recording(tmp_path: Path) -> None:
    """A contact level in the array file above the grip's strains, and one on the command line below them."""
    description, stream = sent("native", 0.6)
    plain = write_array(tmp_path, description.text)
    text = plain.read_text(encoding="utf-8") + "[thresholds]\ncontact_level = 0.5\nsigmas = [0, 0, 0]\n"
    array, files = write_array(tmp_path, text), [tmp_path / f"r.{form}" for form in ("mcap", "npz", "csv")]
    for more, level in ((), 0.5), (("--contact-level", "1e-4"), 1e-4):
        with device(stream) as emulator:
            live = call("live", "-p", emulator.port, "-a", array, "--record", files[0], "--json", "--tare", "off",
                        "--once", "--replace", *more)  # fmt: skip
        found = events(live, as_lines=True)
        assert ("contact" in {kind for _, _, kind, _ in found}) is (level < 0.5)
        assert events(call("replay", files[0], "--json"), as_lines=True) == found
        for file in files:
            if file != files[0]:
                assert call("convert", files[0], file, "--replace").exit_code == 0
            ran = call("run", file, "--json")
            assert events(ran) == found
            settings = json.loads(ran.stdout)["settings"]
            assert settings["contact"] == {"dead_band": level, "hysteresis": level / 2}
            assert settings["sigmas"] == {"dead_band": 0, "hysteresis": 0, "contact": 0}
            assert (settings["tare"], settings["window"], settings["backend"]) == ("off", 128, "cpu")
    again = call("run", files[1], "--json", "--contact-level", "0.5")
    assert not [event for event in json.loads(again.stdout)["events"] if event["kind"] == "contact"]
    bare = call("replay", files[0], "--sign-code", "--json")
    assert bare.exit_code == 0, bare.output


def test_the_commented_lines_of_a_new_array_are_valid(tmp_path: Path) -> None:
    call("new", "array", "all", "-o", tmp_path)
    path = tmp_path / "all.toml"
    names = ("[thresholds]", "dead_band", "hysteresis", "contact_level", "sigmas")
    path.write_text("\n".join(
        line.removeprefix("# ") if line.removeprefix("# ").startswith(names) else line
        for line in path.read_text(encoding="utf-8").splitlines()
    ))  # fmt: skip
    chosen = read_description(path).thresholds
    assert chosen.sigmas == (4, 6, 3)
    assert (chosen.dead_band, chosen.hysteresis, chosen.contact_level) == (1e-3, 5e-4, 1e-3)
