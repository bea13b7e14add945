"""Replay of recordings without the bytes of a port: the events of a run, on time, with a layout."""

import json
import time
from pathlib import Path
from typing import Any

import numpy as np

import tactile
from tests.kits.paths import ROOT
from tests.kits.serial import call

GRASP = ROOT / "examples" / "grasp.npz"


def replayed(*arguments: Any) -> list[dict[str, Any]]:
    result = call("replay", *arguments, "--json")
    assert result.exit_code == 0, result.output
    return [json.loads(line) for line in result.stdout.splitlines()]


def test_the_events_are_those_of_a_run() -> None:
    lines = replayed(GRASP)
    wanted = [(round(one.t, 9), one.kind) for one in tactile.run(GRASP).events]
    assert [(round(one["t_s"], 9), one["kind"]) for one in lines if one["type"] == "event"] == wanted
    assert wanted
    assert lines[-1]["type"] == "end"
    assert lines[-1]["events"] == len(wanted)


def test_a_table_of_another_program_is_replayed_on_time(tmp_path: Path) -> None:
    t = np.arange(0, 2, 0.01)
    force = np.random.default_rng(1).normal(0, 0.002, (200, 4, 3))
    force[t >= 1.5, :, 2] += 0.3
    table = tmp_path / "glove.csv"
    head = "t;" + ";".join(f"S{k}_F{a}" for k in range(4) for a in "xyz")
    np.savetxt(table, np.column_stack([t, force.reshape(200, 12)]), fmt="%.4f", delimiter=";", header=head, comments="")
    assert "a table of another one" in call("replay", table).output
    layout = tmp_path / "layout.toml"
    assert call("layout", table, "-o", layout).exit_code == 0
    start = time.monotonic()
    lines = replayed(table, "--layout", layout, "--speed", "10")
    assert time.monotonic() - start >= 0.199
    assert next(one["kind"] for one in lines if one["type"] == "event") == "contact"
    assert lines[-1]["counts"]["good"] == 200
