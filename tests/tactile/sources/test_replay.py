"""CSV and NPZ recordings: exact round trips, and errors with file and line."""

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from cnnsim.support import InputError
from tactile.core.frame import Frame, TaxelArray
from tactile.core.source import FrameStream, Source
from tactile.simulator.scene_file.file import read_scene, scene_from
from tactile.sources import open_source
from tactile.sources.replay_csv import read_csv, write_csv
from tactile.sources.replay_npz import read_npz, write_npz
from tactile.sources.replay_parquet import write_parquet
from tests.kits.touch.source import GRIP, parsed


def same(a: Frame, b: Frame) -> bool:
    return (
        (a.finger, a.t, a.sequence) == (b.finger, b.t, b.sequence)
        and np.array_equal(a.t_device, b.t_device, equal_nan=True)
        and np.array_equal(a.values, b.values, equal_nan=True)
        and np.array_equal(a.valid, b.valid)
    )


def mixed() -> FrameStream:
    """Fingers of different sizes and quantities, a device clock, extreme values and an invalid taxel."""
    random = np.random.default_rng(0)
    arrays = (
        TaxelArray("left-_1", 1, 2, 1.5e-3, 0.1 + 0.2, (1 / 3, -2e-3), thickness=1 / 3),
        TaxelArray("right", 2, 2, 7e-3, 0.0, quantity="force"),
    )
    frames = []
    for k in range(6):
        values = random.normal(size=(*arrays[k % 2].shape, 3)) * 10.0 ** random.uniform(-300, 300)
        values[0, 0, 1] = np.nan if k == 3 else -0.0
        frames.append(Frame(k % 2, k / 7, 100 + k, values, np.isfinite(values).all(-1), k / 3 if k else np.nan))
    return FrameStream('a "title" # with\nlines', arrays, 2.4e6 / 7, len(frames), frames)


@pytest.mark.parametrize("make", [mixed, lambda: read_scene(GRIP)], ids=["mixed", "grip"])
def test_csv_round_trip_is_exact(tmp_path: Path, make: Callable[[], Source]) -> None:
    source, path = make(), tmp_path / "r.csv"
    write_csv(path, source)
    back = open_source(path)
    assert (back.title, back.arrays, back.modulus, back.frames) == (
        source.title,
        source.arrays,
        source.modulus,
        source.frames,
    )
    for a, b in zip(source, back, strict=True):
        usable = np.where(a.valid[..., None], a.values, np.nan)
        assert same(Frame(a.finger, a.t, a.sequence, usable, a.valid, a.t_device), b)


def broken(tmp_path: Path, number: int, change: Callable[[str], str]) -> Path:
    """A recording with one changed line: lines 1 to 11 are the header, 12 the column names, 13 the first frame."""
    path = tmp_path / "r.csv"
    write_csv(path, scene_from(parsed(), "here"))
    lines = path.read_text().splitlines()
    lines[number - 1] = change(lines[number - 1])
    path.write_text("\n".join(lines))
    return path


@pytest.mark.parametrize(
    ("number", "change", "message"),
    [
        (15, lambda line: line[: len(line) // 2], r"line 15: \d+ columns, 23 wanted for finger 'left'"),
        (15, lambda line: line + ",1", "line 15: 24 columns, 23 wanted"),
        (14, lambda line: line.replace("left", "top"), "line 14: finger 'top', one of left"),
        (14, lambda line: "x" + line, "line 14: t_s = 'x0.01', a number"),
        (14, lambda line: "," + line.split(",", 1)[1], "line 14: t_s = '', a finite time"),
        (17, lambda line: line[:-1] + "z", "line 17: n5 = .*z', a number or nothing"),
        (15, lambda line: line.replace(",left,2,0,", ",left,2,-1,"), "line 15: flags -1, from 0 to"),
        (15, lambda line: line.replace(",left,2,0,", ",left,2,x,"), "line 15: flags 'x', a whole number"),
        (12, lambda _: "a,b", "line 12: 'a,b', the column names 't_s,t_device_s,finger"),
        (1, lambda _: "# tactile_recording = 2", "tactile_recording = 2, 1 wanted"),
        (6, lambda _: "# rows = 2.5", "finger 1: rows = 2.5, a whole number"),
        (6, lambda _: "# row = 2", "unknown key 'row'.*; did you mean 'rows'"),
        (6, lambda _: "# rows 2", "not TOML"),
        (11, lambda _: '# quantity = "volts"', "quantity = 'volts', one of strain"),
    ],
)
def test_broken_csv_names_file_and_line(
    tmp_path: Path, number: int, change: Callable[[str], str], message: str
) -> None:
    with pytest.raises(InputError, match=message) as caught:
        read_csv(broken(tmp_path, number, change))
    assert "r.csv" in str(caught.value)


def test_the_flags_column_is_optional(tmp_path: Path) -> None:
    path = broken(tmp_path, 1, str)
    lines = path.read_text(encoding="utf-8").splitlines()
    without_flags = [
        line if line.startswith("#") else ",".join(line.split(",")[:4] + line.split(",")[5:]) for line in lines
    ]
    with_flags = [frame.values for frame in read_csv(path)]
    path.write_text("\n".join(without_flags), encoding="utf-8")
    assert np.array_equal(with_flags, [frame.values for frame in read_csv(path)])


def test_empty_and_nan_cells_are_invalid_taxels(tmp_path: Path) -> None:
    path = broken(tmp_path, 14, lambda line: ",".join([*line.split(",")[:5], "", *line.split(",")[6:-1], "NaN"]))
    frame = list(read_csv(path))[1]
    assert frame.valid.tolist() == [[False, True, True], [True, True, False]]


def test_missing_frames_missing_file_and_unknown_suffix_are_refused(tmp_path: Path) -> None:
    path = tmp_path / "r.csv"
    write_csv(path, scene_from(parsed(), "here"))
    path.write_text("\n".join(path.read_text().splitlines()[:12]))
    with pytest.raises(InputError, match="no frames"):
        read_csv(path)
    with pytest.raises(InputError, match=r"nothing\.csv"):
        open_source(tmp_path / "nothing.csv")
    with pytest.raises(InputError, match=r"'.xyz', a scene or recording in .toml, .npz, .csv"):
        (tmp_path / "r.xyz").touch()
        open_source(tmp_path / "r.xyz")


@dataclass
class Pillars:
    """The arrays of an NPZ recording, which a test may change."""

    arrays: dict[str, Any]

    def save(self, path: Path) -> Path:
        np.savez(path, **self.arrays)
        return path


def pillars(sensors: tuple[int, ...] = (0, 1), length: int = 5) -> Pillars:
    arrays: dict[str, Any] = {}
    for s in sensors:
        force = np.arange(length * 27, dtype=np.float32).reshape(length, 9, 3) + 1000 * s
        arrays |= {f"s{s}_force": force, f"s{s}_t_ns": 10**18 + 2_000_000 * np.arange(length) + 500_000 * (1 - s)}
        arrays |= {f"s{s}_seq": 7 + np.arange(length), f"s{s}_tus": 1000 * np.arange(length)}
    return Pillars(arrays)


def test_npz_merges_sensors_by_time(tmp_path: Path) -> None:
    source = read_npz(pillars().save(tmp_path / "run.npz"))
    frames = list(source)
    assert (source.title, source.frames, source.modulus) == ("run", 10, None)
    assert [frame.finger for frame in frames] == [1, 0] * 5
    assert [frame.t for frame in frames[:3]] == pytest.approx([0, 0.5e-3, 2e-3], abs=1e-15)
    assert frames[2].t_device == 1e-3
    assert frames[2].sequence == 8
    assert frames[2].values.tolist() == (np.arange(27, 54) + 1000.0).reshape(3, 3, 3).tolist()
    assert {(a.shape, a.quantity, a.pitch) for a in source.arrays} == {((3, 3), "force", 7e-3)}
    one = read_npz(pillars((0,)).save(tmp_path / "one.npz"))
    assert [array.name for array in one.arrays] == ["sensor-0"]


@pytest.mark.parametrize(
    ("name", "value", "message"),
    [
        ("s1_t_ns", None, "s1_t_ns is missing"),
        ("s1_force", np.zeros((5, 8, 3)), "8 pillars, a square number"),
        ("s1_force", np.zeros((5, 27)), r"shape \(5, 27\)"),
        ("s0_seq", np.arange(4), r"s0_seq of shape \(4,\)"),
        ("s0_tus", np.zeros(5), "type float64"),
    ],
)
def test_wrong_npz_is_refused(tmp_path: Path, name: str, value: Any, message: str) -> None:
    changed = pillars()
    changed.arrays[name] = value
    if value is None:
        del changed.arrays[name]
    with pytest.raises(InputError, match=message):
        read_npz(changed.save(tmp_path / "r.npz"))


def test_host_stamps_that_step_back_are_replaced_by_the_device_clock(tmp_path: Path) -> None:
    changed = pillars((0,), 20)
    changed.arrays["s0_t_ns"][12:] -= 10**9
    source = read_npz(changed.save(tmp_path / "r.npz"))
    frames = list(source)
    assert [frame.sequence for frame in frames] == list(range(7, 27))
    assert [frame.t for frame in frames] == pytest.approx([n / 1000 for n in range(20)], abs=1e-9)
    (note,) = source.notes
    assert "step back by 0.998 s at sample 12; the times of the device are used" in note
    changed.arrays["s0_tus"][:], changed.arrays["s0_seq"][:] = 5, 5
    with pytest.raises(InputError, match="there is no other clock"):
        read_npz(changed.save(tmp_path / "r.npz"))


def test_npz_of_something_else_is_refused(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="holds a; s0_force"):
        read_npz(Pillars({"a": 1}).save(tmp_path / "r.npz"))
    (tmp_path / "text.npz").write_text("no archive")
    with pytest.raises(InputError, match=r"text\.npz"):
        read_npz(tmp_path / "text.npz")
    (tmp_path / "cut.npz").write_bytes((tmp_path / "r.npz").read_bytes()[:100])
    with pytest.raises(InputError, match=r"cut\.npz"):
        read_npz(tmp_path / "cut.npz")


def test_a_folder_that_is_no_ros_bag_is_refused(tmp_path: Path) -> None:
    folder = tmp_path / "scene.toml"
    folder.mkdir()
    with pytest.raises(InputError, match=r"scene\.toml: a folder, and no ROS bag \(no metadata\.yaml in it\)"):
        open_source(folder)


@pytest.mark.parametrize("suffix", (".csv", ".npz", ".parquet"))
def test_stamps_that_step_back_are_replaced_with_a_sentence(tmp_path: Path, suffix: str) -> None:
    array = TaxelArray("left", 1, 1, 1e-3, 1e-3)

    def written(times: list[float], sequence: list[int], device: bool) -> Path:
        frames = [
            Frame(0, t, n, np.ones((1, 1, 3)), np.ones((1, 1), bool), 7 + n / 100 if device else np.nan)
            for t, n in zip(times, sequence, strict=True)
        ]
        path = tmp_path / f"r{suffix}"
        write = {".csv": write_csv, ".npz": write_npz, ".parquet": write_parquet}[suffix]
        write(path, FrameStream("r", (array,), 1e6, len(frames), frames))
        return path

    stepped = [2.0, 2.01, 1.5, 2.03, 2.04]
    for device, clock in ((True, "the device"), (False, "the sequence numbers")):
        source = open_source(written(stepped, [0, 1, 2, 3, 4], device))
        assert [frame.t for frame in source] == pytest.approx([2.0, 2.01, 2.02, 2.03, 2.04])
        (note,) = getattr(source, "notes")  # noqa: B009 - of some sources
        assert f"'left' step back by 0.51 s at sample 2; the times of {clock} are used" in note
    with pytest.raises(InputError, match=r"step back by 0.51 s at sample 2, and there is no other clock"):
        open_source(written(stepped, [0, 1, 1, 0, 4], False))
