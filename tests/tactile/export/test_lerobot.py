"""`convert --lerobot`: episodes in the published format of LeRobotDataset v3.0; `convert --tared`."""

import json
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd  # type: ignore[import-untyped]  # it ships no types
import pytest
from pyarrow import parquet  # type: ignore[import-untyped]  # it ships no types

import tactile
from tactile.core.source import provenance
from tactile.export.episode import PHASES
from tests.kits.serial import call
from tests.kits.touch.presses import PADS, START, write_presses

FPS = 25


@pytest.fixture(scope="module")
def made(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("lerobot")
    (folder / "takes").mkdir()
    write_presses(folder / "takes" / "a.npz")
    write_presses(folder / "takes" / "b.npz", rate=60.0, seconds=1.8, seed=1)
    (folder / "takes" / "notes.txt").write_text("two takes")
    done = call("convert", folder / "takes", "--lerobot", folder / "set", "--fps", FPS, "--task", "press twice")
    assert done.exit_code == 0, done.output
    assert "2 episodes" in done.stdout
    assert "notes.txt: passed over" in done.stderr
    return folder


def rows_of(made: Path) -> list[Any]:
    return [parquet.read_table(path) for path in sorted((made / "set" / "data").rglob("*.parquet"))]


def column(table: Any, name: str) -> np.ndarray:
    return np.array(table[name].to_pylist())


def test_the_files_are_those_of_the_published_format(made: Path) -> None:
    info = json.loads((made / "set" / "meta" / "info.json").read_text())
    assert (info["codebase_version"], info["fps"], info["total_episodes"]) == ("v3.0", FPS, 2)
    tables = rows_of(made)
    assert info["total_frames"] == sum(table.num_rows for table in tables)
    episodes = parquet.read_table(made / "set" / "meta" / "episodes" / "chunk-000" / "file-000.parquet").to_pylist()
    tasks = pd.read_parquet(made / "set" / "meta" / "tasks.parquet")
    assert tasks.loc["press twice", "task_index"] == 0
    assert tasks.iloc[0].name == "press twice"
    start = 0
    for number, (table, episode) in enumerate(zip(tables, episodes, strict=True)):
        path = info["data_path"].format(
            chunk_index=episode["data/chunk_index"], file_index=episode["data/file_index"]
        )  # fmt: skip
        assert (made / "set" / path).is_file()
        assert table.column_names == list(info["features"])
        assert (episode["dataset_from_index"], episode["dataset_to_index"]) == (start, start + table.num_rows)
        assert episode["tasks"] == ["press twice"]
        assert table["index"].to_pylist() == list(range(start, start + table.num_rows))
        assert str(table.schema.field("timestamp").type) == "float"
        assert np.allclose(column(table, "timestamp"), np.arange(table.num_rows) / FPS)
        assert set(table["episode_index"].to_pylist()) == {number}
        start += table.num_rows
    for name, feature in info["features"].items():
        shape = column(tables[0], name).shape[1:]
        assert list(shape or (1,)) == feature["shape"], name


def test_observations_are_the_latest_tared_samples_and_windows_hold_all_between_two_frames(made: Path) -> None:
    about = json.loads((made / "set" / "meta" / "tactile.json").read_text())
    for take, table, episode in zip("ab", rows_of(made), about["episodes"], strict=True):
        with tactile.stream(made / "takes" / f"{take}.npz") as frames:
            samples = [frame for frame in frames if frame.finger == "thumb"]
        times = np.array([frame.t for frame in samples])
        assert episode["start_ns"] == START
        assert episode["first_frame_ns"] == START + round(episode["first_frame_s"] * 1e9)
        at = episode["first_frame_s"] + column(table, "timestamp")
        latest = np.searchsorted(times, at + 1e-6, "right") - 1
        wanted = np.array([samples[n].values.reshape(-1, 3) for n in latest])
        assert np.allclose(column(table, "observation.tactile.thumb"), wanted, atol=1e-6)
        window = column(table, "observation.tactile.thumb.window")
        counts = table["observation.tactile.thumb.window_count"].to_pylist()
        together = np.concatenate([one[:count] for one, count in zip(window, counts, strict=True)][1:])
        between = [frame.values.reshape(-1, 3) for frame in samples[latest[0] + 1 : latest[-1] + 1]]
        assert np.allclose(together, np.array(between), atol=1e-6)
        assert np.allclose(window[:, -1], wanted, atol=1e-6)  # padded with the last sample
        assert column(table, "observation.tactile.thumb.valid").all()


def test_labels_follow_the_events_and_statistics_cover_all_episodes(made: Path) -> None:
    tables = rows_of(made)
    for table in tables:
        phase = [PHASES[number] for number in table["annotation.tactile.thumb.phase"].to_pylist()]
        assert phase[0] == "approach"
        assert {"load", "release"} & set(phase)
        pressed = column(table, "observation.tactile.thumb")[..., 2].mean(-1) > 0.2
        code = column(table, "observation.tactile.thumb.code")
        assert np.array_equal(code[..., 2].all(-1), pressed)
        assert 8 < pressed.sum() < 16
    stats = json.loads((made / "set" / "meta" / "stats.json").read_text())["observation.tactile.palm"]
    both = np.concatenate([column(table, "observation.tactile.palm") for table in tables])
    for name, wanted in (("min", both.min(0)), ("max", both.max(0)), ("mean", both.mean(0)), ("std", both.std(0))):
        assert np.allclose(stats[name], wanted, atol=1e-6), name
    assert stats["count"] == [len(both)]
    assert {"q01", "q10", "q50", "q90", "q99"} <= set(stats)


@pytest.mark.parametrize("suffix", [".csv", ".mcap"])
def test_tared_frames_keep_the_start_and_give_the_events_without_a_tare(tmp_path: Path, suffix: str) -> None:
    take = write_presses(tmp_path / "a.npz", seconds=1.7)
    done = call("convert", take, tmp_path / f"b{suffix}", "--tared")
    assert done.exit_code == 0, done.output
    source = tactile.open_source(tmp_path / f"b{suffix}")
    assert provenance(source).start_ns == START
    assert not provenance(source).untared
    frames = list(source)
    assert not frames[0].valid.any()
    held = [frame for frame in frames if 1.1 < frame.t < 1.4]
    assert abs(np.mean([frame.values[..., 2].mean() for frame in held]) - 0.4) < 0.01
    with tactile.stream(tmp_path / f"b{suffix}") as stream:
        begun = [event for frame in stream for event in frame.begun if event.kind == "contact"]
    assert {event.finger for event in begun} == {pad.name for pad in PADS}
    assert max(abs(event.t - 1.0) for event in begun) < 0.05


def test_wrong_requests_are_refused(tmp_path: Path) -> None:
    take = write_presses(tmp_path / "a.npz", seconds=0.1)
    (tmp_path / "set").mkdir()
    for words, message in (
        ((take,), "one target wanted"), ((take, tmp_path / "b.csv", "--lerobot", tmp_path / "x"), "one target wanted"),
        ((take, tmp_path / "b.csv", "--fps", "10"), "belong to --lerobot"),
        ((take, "--lerobot", tmp_path / "set"), "there is something of that name"),
        ((take, "--lerobot", tmp_path / "new"), "finger 'thumb': no tared sample"),
    ):  # fmt: skip
        done = call("convert", *words)
        assert done.exit_code == 2, done.output
        assert message in done.stderr
    assert {path.name for path in tmp_path.iterdir()} == {"a.npz", "set"}
