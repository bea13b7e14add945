"""Conversion of recordings into other forms and back."""

from pathlib import Path

import numpy as np
import pytest
from mcap.reader import make_reader

from cnnsim.support import InputError
from tactile.recording.reader import open_recording
from tactile.sources import open_source
from tactile.sources.convert import convert, open_any
from tactile.sources.replay_csv import write_csv
from tests.kits.serial import GRIP, call, grip
from tests.tactile.recording.test_reader import recorded, same
from tests.tactile.sources.test_replay import pillars


def test_conversions(tmp_path: Path) -> None:
    recorded(tmp_path / "r.mcap")
    frames = list(open_recording(tmp_path / "r.mcap").source())
    for name in ("r.csv", "indexed.mcap", "r.npz", "r.parquet"):
        result = call("convert", tmp_path / "r.mcap", tmp_path / name)
        assert (result.exit_code, result.output) == (0, f"wrote 200 frames to {tmp_path / name}\n")
    same(list(open_source(tmp_path / "r.csv")), frames)
    same(list(open_any(tmp_path / "indexed.mcap")), frames)
    with (tmp_path / "indexed.mcap").open("rb") as file:
        summary = make_reader(file).get_summary()
    assert summary is not None
    assert summary.chunk_indexes
    with np.load(tmp_path / "r.npz") as file:
        assert file["s0_strain"].shape == (100, 4, 3)
        assert file["s1_seq"].tolist() == list(range(100))
        assert file["s0_tus"][:3].tolist() == [0, 5000, 10000]
    parquet = pytest.importorskip("pyarrow.parquet")
    table = parquet.read_table(tmp_path / "r.parquet").to_pylist()
    assert [row["finger"] for row in table[:3]] == ["left", "right", "left"]
    assert np.array_equal(table[7]["values"], frames[7].values.ravel())


def test_recordings_of_other_kinds_become_mcap_and_come_back(tmp_path: Path) -> None:
    npz = pillars().save(tmp_path / "run.npz")
    for source in (npz, GRIP):
        frames = list(open_source(source))
        assert convert(source, tmp_path / "r.mcap", overwrite=True) == len(frames)
        got = list(open_any(tmp_path / "r.mcap"))
        same(got, frames)
    convert(npz, tmp_path / "r.mcap", overwrite=True)
    convert(tmp_path / "r.mcap", tmp_path / "again.npz")
    same(list(open_any(tmp_path / "again.npz")), [*open_source(npz)])
    write_csv(tmp_path / "g.csv", grip(0.1))
    assert convert(tmp_path / "g.csv", tmp_path / "g.mcap") == 40
    for wrong, message in (("x.bag2", "one of .csv"), ("run.npz", "is the recording itself")):
        with pytest.raises(InputError, match=message):
            convert(npz, tmp_path / wrong)
