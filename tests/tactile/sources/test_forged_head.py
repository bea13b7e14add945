"""Recordings whose head says other arrays than their frames are of, its sums being right: both sizes, and no memory."""

import tracemalloc
from io import BytesIO
from pathlib import Path

import numpy as np
import pyarrow.parquet as pq  # type: ignore[import-untyped]  # it ships no types
import pytest
from mcap.reader import make_reader
from mcap.writer import Writer

from cnnsim.support import InputError
from tactile import Frame, TaxelArray, open_source
from tactile.core.source import FrameStream
from tactile.recording import schema
from tactile.recording.index import write_frames
from tactile.sources.replay_csv import write_csv
from tactile.sources.replay_npz import write_npz
from tactile.sources.replay_parquet import write_parquet


def source() -> FrameStream:
    array = TaxelArray("pad", 2, 2, pitch=1e-3, depth=1e-3)
    frames = [Frame(0, 0.01 * k, k, np.full((2, 2, 3), 1e-3 * k), np.ones((2, 2), bool)) for k in range(20)]
    return FrameStream("pad", (array,), 2e6, len(frames), frames)


def grown(text: str, rows: int, cols: int) -> str:
    return text.replace("rows = 2\n", f"rows = {rows}\n").replace("cols = 2\n", f"cols = {cols}\n")


def forge(path: Path, rows: int, cols: int) -> None:
    """Write a recording of 2 x 2 taxels whose head says others."""
    kind = path.suffix
    if kind == ".csv":
        write_csv(path, source())
        path.write_text(grown(path.read_text(), rows, cols))
    elif kind == ".npz":
        write_npz(path, source())
        held = dict(np.load(path))
        held["tactile"] = np.array(grown(str(held["tactile"]), rows, cols))
        np.savez(path, **held)
    elif kind == ".parquet":
        write_parquet(path, source())
        table = pq.read_table(path)
        head = {key: grown(value.decode(), rows, cols).encode() for key, value in table.schema.metadata.items()}
        pq.write_table(table.replace_schema_metadata(head), path)
    else:
        forge_mcap(path, rows, cols)


def forge_mcap(path: Path, rows: int, cols: int, *, frames_too: bool = False) -> None:
    write_frames(path, source())
    whole = path.read_bytes()
    with path.open("wb") as out:
        writer = Writer(out, enable_data_crcs=True)
        writer.start()
        for one in make_reader(BytesIO(whole)).iter_metadata():
            made = {key: grown(value, rows, cols) for key, value in one.metadata.items() if key != schema.SUM}
            writer.add_metadata(one.name, made | ({schema.SUM: schema.sum_of(made)} if one.name == "tactile" else {}))
        for added in make_reader(BytesIO(whole)).iter_attachments():
            writer.add_attachment(added.create_time, added.log_time, added.name, added.media_type, added.data)
        kinds: dict[int, int] = {}
        for of, channel, message in make_reader(BytesIO(whole)).iter_messages():
            if of is not None and channel.id not in kinds:
                number = writer.register_schema(of.name, of.encoding, of.data)
                kinds[channel.id] = writer.register_channel(channel.topic, channel.message_encoding, number)
            data = bytearray(message.data)
            if frames_too:
                data[36:44] = np.array([rows, cols], "<u4").tobytes()
            writer.add_message(kinds[channel.id], message.log_time, bytes(data), message.publish_time)
        writer.finish()  # type: ignore[no-untyped-call]  # the library left its types out


SAID = {
    ".csv": "the column names .* wanted: 3145733, not 17",
    ".npz": r"values of shape \(20, 2, 2, 3\).*\(20, 1024, 1024, 3\)",
    ".parquet": "12 values and 4 flags, 3145728 and 1048576 of 1024 x 1024 taxels wanted",
    ".mcap": "a frame of 2 x 2 taxels, of which its head says 1024 x 1024",
}


@pytest.mark.parametrize("kind", SAID)
def test_a_head_of_giant_arrays_is_refused_before_room_is_made(tmp_path: Path, kind: str) -> None:
    path = tmp_path / f"forged{kind}"
    forge(path, 2, 2)
    assert sum(1 for _ in open_source(path)) == 20
    path.unlink()
    forge(path, 1024, 1024)
    tracemalloc.start()
    with pytest.raises(InputError, match=SAID[kind]) as caught:
        open_source(path)
    assert tracemalloc.get_traced_memory()[1] < 4e6
    tracemalloc.stop()
    assert len(str(caught.value)) < 600


def test_frames_that_say_more_than_is_in_them(tmp_path: Path) -> None:
    forge_mcap(tmp_path / "forged.mcap", 1000, 1000, frames_too=True)
    with pytest.raises(InputError, match="a frame of 156 bytes says 1000 x 1000 taxels, which take 25000052"):
        open_source(tmp_path / "forged.mcap")
