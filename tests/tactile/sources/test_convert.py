"""Conversion between CSV, NPZ, Parquet and MCAP recordings."""

import sys
from dataclasses import replace
from itertools import permutations
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from mcap.reader import make_reader

from cnnsim.support import InputError
from tactile.core.epoch import Epoch
from tactile.core.frame import Frame, TaxelArray
from tactile.core.source import FrameStream, Provenance, provenance
from tactile.live_options import LiveOptions
from tactile.recording.reader import open_recording
from tactile.recording.writer import Recording
from tactile.sources import open_source
from tactile.sources.convert import WRITERS, convert
from tactile.sources.replay_csv import write_csv
from tactile.wire.description_file import parse_description
from tactile.wire.packets import packets
from tactile.wire.source import Chunk
from tests.kits.serial import GRIP, call, grip
from tests.tactile.recording.test_reader import recorded, same
from tests.tactile.sources.test_replay import pillars


def test_a_recording_converts_to_every_form(tmp_path: Path) -> None:
    recorded(tmp_path / "r.mcap")
    frames = list(open_recording(tmp_path / "r.mcap").source())
    for name in ("r.csv", "indexed.mcap", "r.npz", "r.parquet"):
        result = call("convert", tmp_path / "r.mcap", tmp_path / name)
        assert (result.exit_code, result.stdout) == (0, f"wrote 200 frames to {tmp_path / name}\n")
        omitted = "100 messages of /wire, 1 messages of /port, 2 messages of /log, 1 messages of /tare"
        assert result.stderr == ("" if name == "indexed.mcap" else f"stays in {tmp_path / 'r.mcap'}: {omitted}\n")
        same(list(open_source(tmp_path / name)), frames)
    with (tmp_path / "indexed.mcap").open("rb") as file:
        summary = make_reader(file).get_summary()
    assert summary is not None
    assert summary.chunk_indexes
    with np.load(tmp_path / "r.npz") as file:
        assert file["s0_values"].shape == (100, 2, 2, 3)
        assert file["s1_sequence"].tolist() == list(range(100))
        assert file["s0_t_device_s"][:3].tolist() == [0, 0.005, 0.01]
    parquet = pytest.importorskip("pyarrow.parquet")
    table = parquet.read_table(tmp_path / "r.parquet").to_pylist()
    assert [row["finger"] for row in table[:3]] == ["left", "right", "left"]
    assert np.array_equal(table[7]["values"], frames[7].values.ravel())


FORMS = (".csv", ".npz", ".parquet", ".mcap")
NAMES = st.lists(st.from_regex(r"[A-Za-z0-9_][A-Za-z0-9_-]{0,8}", fullmatch=True), min_size=1, max_size=3, unique=True)
LENGTHS = st.floats(1e-9, 1e3)
NUMBERS = st.floats(width=64)


@st.composite
def streams(draw: st.DrawFn) -> FrameStream:
    """Streams of random arrays and frames, also with fingers without frames and without device clocks."""
    arrays = tuple(
        TaxelArray(
            name, draw(st.integers(1, 2)), draw(st.integers(1, 3)), draw(LENGTHS), draw(LENGTHS),
            (draw(st.floats(-1, 1)), draw(st.floats(-1, 1))), draw(st.sampled_from(("strain", "stress", "force"))),
            draw(st.one_of(st.none(), st.floats(1e3, 1e6))),
        )
        for name in draw(NAMES)
    )  # fmt: skip
    times = sorted(draw(st.lists(st.floats(0, 1e6), min_size=1, max_size=4)))
    frames = []
    for t in times:
        finger = draw(st.integers(0, len(arrays) - 1))
        rows, cols = arrays[finger].shape
        count = rows * cols
        values = np.array(draw(st.lists(NUMBERS, min_size=3 * count, max_size=3 * count))).reshape(rows, cols, 3)
        valid = np.array(draw(st.lists(st.booleans(), min_size=count, max_size=count))).reshape(rows, cols)
        device = draw(st.one_of(st.just(float("nan")), st.floats(0, 1e9)))
        flags = draw(st.integers(0, 2**32 - 1))
        frames.append(Frame(finger, t, draw(st.integers(-(2**63), 2**63 - 1)), values, valid, device, flags))
    raw = tuple(array.name for array in arrays if draw(st.booleans()))
    start = draw(st.one_of(st.none(), st.integers(0, 2**62)))
    known = Provenance(draw(st.booleans()), raw, start, choices=draw(st.sampled_from(("", LiveOptions().text()))))
    modulus = draw(st.one_of(st.none(), LENGTHS))
    return FrameStream(draw(st.text(max_size=12)), arrays, modulus, len(frames), frames, known)


def through_csv(frame: Frame) -> Frame:
    values = np.where(frame.valid[..., None], frame.values, np.nan)
    return replace(frame, values=values, valid=np.asarray(np.isfinite(values).all(-1)))


@given(streams())
@settings(max_examples=6, deadline=None)
def test_every_pair_of_forms_round_trips(source: FrameStream) -> None:
    with TemporaryDirectory() as folder:
        for first, second in permutations(FORMS, 2):
            one, other = Path(folder) / f"to{second}{first}", Path(folder) / f"of{first}{second}"
            WRITERS[first](one, source)
            converted = convert(one, other)
            back = open_source(other)
            assert converted.frames == source.frames
            assert (back.title, back.arrays, back.modulus) == (source.title, source.arrays, source.modulus)
            assert provenance(back) == source.provenance
            wanted = [through_csv(frame) if ".csv" in (first, second) else frame for frame in source]
            for a, b in zip(wanted, back, strict=True):
                assert (a.finger, a.t, a.sequence, a.flags) == (b.finger, b.t, b.sequence, b.flags)
                assert np.array_equal(a.t_device, b.t_device, equal_nan=True)
                assert np.array_equal(a.values, b.values, equal_nan=True)
                assert np.array_equal(np.signbit(a.values[a.valid]), np.signbit(b.values[a.valid]))
                assert np.array_equal(a.valid, b.valid)
            lost = any((frame.valid != through_csv(frame).valid).any() for frame in source)
            assert not lost or second != ".csv" or first == ".csv" or "not in" in " ".join(converted.notes)


@pytest.mark.parametrize("form", FORMS)
def test_the_device_description_round_trips(tmp_path: Path, form: str) -> None:
    """Pitch, names, cells, and the unit of uncalibrated readings."""
    text = """title = "t"
protocol = "reskin"
[[finger]]
name = "thumb"
rows = 3
cols = 3
pitch_mm = 5.0
depth_mm = 2.0
thickness_mm = 2.3
quantity = "force"
cells = [[-1, 1, -1], [4, 0, 2], [-1, 3, -1]]
"""
    described = parse_description(text, "here")
    recording = Recording(tmp_path / "r.mcap", described, {}, Epoch.now())
    stream = replace(grip(0.05, 1), arrays=(replace(described.arrays[0], quantity="strain"),))
    for t, data in packets(described, stream):
        recording.chunk(Chunk(round(t * 1e9), data))
    recording.close({})
    target = tmp_path / f"made{form}"
    convert(tmp_path / "r.mcap", target)
    again = tmp_path / ("again.npz" if form != ".npz" else "again.csv")
    convert(target, again)
    for path in (tmp_path / "r.mcap", target, again):
        source = open_source(path)
        assert source.arrays == described.arrays
        known = provenance(source)
        assert (known.uncalibrated, known.untared, known.description) == (("thumb",), True, text)
        refused = call("run", path)
        assert refused.exit_code == 2
        assert "finger 'thumb': readings in the unit of the wire" in refused.stderr
    assert len({provenance(open_source(path)).start_ns for path in (tmp_path / "r.mcap", target, again)}) == 1


def test_omitted_data_and_assumed_geometry_are_reported(tmp_path: Path) -> None:
    recording = pillars()
    recording.arrays["s0_global"] = np.zeros(5)
    npz = recording.save(tmp_path / "run.npz")
    errors = call("convert", npz, tmp_path / "r.csv").stderr
    assert "neither pitch nor names: 7 mm, nominal" in errors
    assert f"stays in {npz}: s0_global" in errors
    assert "the loads that it knows to be true" in call("convert", GRIP, tmp_path / "g.parquet").stderr
    frames = [replace(frame, valid=np.full(frame.valid.shape, frame.sequence != 3)) for frame in grip(0.05, 1)]
    WRITERS[".npz"](tmp_path / "m.npz", replace_stream(frames))
    assert "readings of 4 taxels that are not valid" in call("convert", tmp_path / "m.npz", tmp_path / "m.csv").stderr


def replace_stream(frames: list[Frame]) -> FrameStream:
    scene = grip(0.05, 1)
    return FrameStream(scene.title, scene.arrays, scene.modulus, len(frames), frames)


def test_a_failed_conversion_leaves_the_target_unchanged(tmp_path: Path) -> None:
    (tmp_path / "old.npz").write_text("old")
    WRITERS[".parquet"](tmp_path / "none.parquet", replace_stream([]))
    refused = call("convert", tmp_path / "none.parquet", tmp_path / "old.npz", "--replace")
    assert refused.exit_code == 2
    assert "no frames in it" in refused.stderr
    assert (tmp_path / "old.npz").read_text() == "old"
    assert call("convert", GRIP, tmp_path / "x.toml").stderr.count("frames make no scene") == 1
    npz = pillars().save(tmp_path / "run.npz")
    for wrong, message in (("x.bag2", "one of .csv"), ("run.npz", "is the recording itself")):
        with pytest.raises(InputError, match=message):
            convert(npz, tmp_path / wrong)


@pytest.mark.parametrize(("name", "room"), [("g.csv", 300), ("g.npz", 300), ("g.parquet", 300), ("g.mcap", 2500)])
def test_a_full_disk_names_the_target_file_and_leaves_nothing(
    name: str, room: int, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    resource = pytest.importorskip("resource", reason="only Unix limits file sizes")
    most = resource.getrlimit(resource.RLIMIT_FSIZE)
    write_csv(tmp_path / "from.csv", grip(0.1))
    monkeypatch.setattr(sys, "dont_write_bytecode", True)  # cached modules would be truncated
    resource.setrlimit(resource.RLIMIT_FSIZE, (room, most[1]))
    try:
        with pytest.raises(InputError) as raised:
            convert(tmp_path / "from.csv", tmp_path / name)
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, most)
    assert str(raised.value).startswith(f"cannot write {tmp_path / name}: ")
    assert [path.name for path in tmp_path.iterdir()] == ["from.csv"]
