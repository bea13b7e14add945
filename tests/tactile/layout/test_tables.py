"""Foreign tables of every kind: guessed layouts, and frames read by them."""

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import h5py
import numpy as np
import pyarrow as pa  # type: ignore[import-untyped]  # it ships no types
import pytest
from pyarrow import parquet
from scipy.io import savemat

from cnnsim.support import InputError
from tactile.layout.layout import Layout, parse_layout
from tactile.layout.source import read_foreign
from tactile.layout.table import read_table
from tactile.sources import open_source
from tactile.sources.convert import convert
from tests.kits.serial import call

N, RATE = 60, 50.0
T = np.arange(N) / RATE
FORCE = np.add(np.random.default_rng(3).normal(0, [0.01, 0.02, 0.1], (N, 6, 3)).round(4), (0, 0, 0.5))
"""Readings (samples, taxels, axes) of a pad of 2 x 3."""
FORCE[30:, :, 2] += np.arange(6) / 4


def text(path: Path, rows: np.ndarray, head: str, separator: str = ",", decimal: str = ".", end: str = "") -> None:
    lines = [separator.join(f"{one:.4f}" for one in row).replace(".", decimal) + end for row in rows]
    path.write_text(head + "\n".join(lines) + "\n")


def interleaved(path: Path) -> None:
    """Semicolons, decimal commas, a preamble, a unit row, a column of something else, a separator at the end."""
    names = ";".join(f"S{k + 1}_F{a}" for k in range(6) for a in "xyz")
    head = f"## made by hand\n## date: 1;2\nzeit_ms;temp;{names};\nms;C;{';'.join('N' * 18)};\n"
    text(path, np.column_stack([T * 1e3, 0 * T + 21.5, FORCE.reshape(N, -1)]), head, ";", ",", ";")


def planar(path: Path) -> None:
    head = "time [s]\t" + "\t".join(f"{a}{k}" for a in "xyz" for k in range(6)) + "\n"
    text(path, np.column_stack([T, FORCE.swapaxes(1, 2).reshape(N, -1)]), head, "\t")


def by_grid(path: Path) -> None:
    head = "# t_us " + " ".join(f"p_{k // 3}_{k % 3}_{a}" for k in range(6) for a in "XYZ") + "\n"
    text(path, np.column_stack([T * 1e6, FORCE.reshape(N, -1)]), head, "  ")


def mat73(path: Path) -> None:
    with h5py.File(path, "w", userblock_size=512) as file:
        file["run/time"], file["run/force"] = T[None], FORCE.T
    with path.open("r+b") as bare:
        bare.write(b"MATLAB 7.3 MAT-file".ljust(512))


def lerobot(path: Path) -> None:
    flat = pa.FixedSizeListArray.from_arrays(pa.array(FORCE.ravel()), 18)
    columns = {"observation.tactile.left": flat, "action": [[0.0, 1.0]] * N, "timestamp": T, "frame_index": range(N)}
    parquet.write_table(pa.table(columns), path)


def hdf5(path: Path) -> None:
    with h5py.File(path, "w") as file:
        file["touch/taxels"], file["touch/stamp_ns"] = FORCE, (T * 1e9).astype(np.int64) + 17 * 10**17
        file["label"] = "grasp"


def packed(path: Path) -> None:
    np.savez(path, pressure=FORCE.reshape(N, 2, 3, 3), stamp_ms=T * 1e3, note=np.array("x"))


KINDS: dict[str, Callable[[Path], Any]] = {
    "a.csv": interleaved, "b.tsv": planar, "c.txt": by_grid, "d.npz": packed, "f.h5": hdf5, "g.parquet": lerobot,
    "e.mat": lambda path: savemat(path, {"rec": {"t": T, "press": FORCE.reshape(N, 2, 3, 3)}}), "m.mat": mat73,
    "n.npy": lambda path: np.save(path, FORCE.reshape(N, 2, 3, 3)),
}  # fmt: skip


@pytest.mark.parametrize("name", list(KINDS))
def test_the_guessed_layout_of_a_table_reads_it(tmp_path: Path, name: str) -> None:
    path, layout = tmp_path / name, tmp_path / "hand.toml"
    KINDS[name](path)
    result = call("layout", path, "-o", layout)
    assert result.exit_code == 0, result.output
    source = open_source(path, layout)
    frames = list(source)
    assert source.arrays[0].shape == (2, 3)
    assert np.abs(np.array([frame.values for frame in frames]).reshape(N, 6, 3) - FORCE).max() < 1e-4
    rate = 100.0 if name == "n.npy" else RATE  # no times in it
    assert np.abs([frame.t for frame in frames] - np.arange(N) / rate).max() < 1e-6
    done = convert(path, tmp_path / "own.npz", opened=source)
    assert done.frames == N
    own = list(open_source(tmp_path / "own.npz"))
    assert all(np.array_equal(a.values, b.values) and a.t == b.t for a, b in zip(frames, own, strict=True))


HEAD = '[layout]\n{top}\n[[finger]]\nname = "f"\nrows = 2\ncols = 3\npitch_mm = 4\ndepth_mm = 0\nquantity = "force"\n'


def layout_of(top: str, finger: str) -> Layout:
    return parse_layout(HEAD.format(top=top) + finger, "hand.toml")


def test_signs_gains_cells_and_the_normal_alone(tmp_path: Path) -> None:
    text(tmp_path / "a.csv", np.column_stack([FORCE[..., 2]]), "")
    layout = layout_of(
        "rate_hz = 50", 'columns = "0..3"\naxes = ["-z"]\ngains = [1, 2]\ncells = [[-1, 1, 0], [2, 3, -1]]\n'
    )
    source = read_foreign(tmp_path / "a.csv", layout)
    frame = next(iter(source))
    assert not source.arrays[0].shear
    assert frame.valid.tolist() == [[False, True, True], [True, True, False]]
    assert frame.values[0, 1:, 2].tolist() == pytest.approx((-2 * FORCE[0, [1, 0], 2]).tolist(), abs=1e-4)
    assert not frame.values[frame.valid][:, :2].any()


def test_fingers_share_a_table_by_rows(tmp_path: Path) -> None:
    rows = [f"{k / 100},{name},{k},{-k}" for k in range(10) for name in ("left", "right")]
    (tmp_path / "a.csv").write_text("t,sensor,z1,z2\n" + "\n".join(rows) + "\n")
    finger = HEAD.format(top="").partition("[[finger]]")[2].replace("rows = 2\ncols = 3", "rows = 1\ncols = 2")
    text_ = '[layout]\ntime = "t"\n' + "".join(
        f'[[finger]]{finger.replace(chr(34) + "f" + chr(34), chr(34) + name + chr(34))}columns = "z{{taxel}}"\n'
        f'axes = ["z"]\nwhere = {{sensor = "{name}"}}\n'
        for name in ("left", "right")
    )
    frames = list(read_foreign(tmp_path / "a.csv", parse_layout(text_, "l")))
    assert [(one.finger, one.t, one.values[0, 0, 2]) for one in frames[:4]] == [
        (0, 0, 0),
        (1, 0, 0),
        (0, 0.01, 1),
        (1, 0.01, 1),
    ]


def test_takes_follow_one_another(tmp_path: Path) -> None:
    two = pa.table(
        {"touch": [one.ravel().tolist() for one in FORCE] * 2, "t": np.tile(T, 2), "episode": [4] * N + [7] * N}
    )
    parquet.write_table(two, tmp_path / "a.parquet")
    with h5py.File(tmp_path / "a.h5", "w") as file:
        for name in ("demo_0", "demo_10", "demo_2"):
            file[f"data/{name}/obs/touch"], file[f"data/{name}/obs/t"] = FORCE, T
    np.save(tmp_path / "a.npy", np.stack([FORCE.reshape(N, 18)] * 2))
    for name, top, finger, count in (
        ("a.parquet", 'time = "t"\ntake = "episode"', 'columns = "touch"', 2),
        ("a.h5", 'time = "obs/t"\ntake = "data/demo_*"', 'columns = "obs/touch"', 3),
        ("a.npy", "rate_hz = 50", 'columns = "data"\ndims = ["take", "time", "taxel"]', 2),
    ):
        source = read_foreign(tmp_path / name, layout_of(top, finger))
        t = np.array([frame.t for frame in source])
        assert t.size == count * N, name
        assert np.flatnonzero(np.diff(t) > 0.5).tolist() == [N * k - 1 for k in range(1, count)]
        assert f"{count} takes, one after another" in source.notes[-1]
    assert "data/demo_0 from 0.000 s, data/demo_2 from 2.180 s" in read_foreign(tmp_path / "a.h5", layout_of(
        'time = "obs/t"\ntake = "data/demo_*"', 'columns = "obs/touch"')).notes[-1]  # fmt: skip


def test_cells_that_are_no_numbers_and_lines_of_other_lengths_are_reported(tmp_path: Path) -> None:
    interleaved(tmp_path / "a.csv")
    lines = (tmp_path / "a.csv").read_text().splitlines()
    lines[6] = lines[6].replace(lines[6].split(";")[2], "ovf")
    lines[7] = lines[7].replace(lines[7].split(";")[3], "")
    lines[9] = "1;2;3"
    (tmp_path / "a.csv").write_bytes("\r\n".join(lines).encode("utf-16"))
    call("layout", tmp_path / "a.csv", "-o", tmp_path / "layout.toml")
    source = open_source(tmp_path / "a.csv")
    assert source.frames == N - 1
    assert [int((~frame.valid).sum()) for frame in source][:4] == [0, 0, 1, 1]
    said = " ".join(getattr(source, "notes", ()))
    assert "1 of 60 lines have not 20 cells and are skipped, the first has 3: '1;2;3'" in said
    assert "S: 2 readings of taxels are no numbers" in said
    told = " ".join(call("run", tmp_path / "a.csv").stderr.split())
    assert all(f"note: {note}" in told for note in getattr(source, "notes", ()))


@pytest.mark.parametrize(
    ("top", "finger", "message"),
    [
        (
            'time = "when"',
            'columns = "S{taxel}_F{axis}"',
            "time 'when': no such column; a.csv has zeit_ms, temp, S1_Fx",
        ),
        ('time = "zeit_ms"', 'columns = "T{taxel}_F{axis}"', "columns 'T{taxel}_F{axis}': no such columns"),
        ('time = "zeit_ms"', 'columns = "2..9"', "8 numbers a sample in a.csv, 6 taxels x 3 axes = 18 wanted"),
        ("", 'columns = "2..9"', "neither time nor rate_hz"),
        ("rate_hz = 0", 'columns = "2..9"', "rate_hz = 0.0, a positive number wanted"),
        (
            'time = "zeit_ms"\ntime_unit = "min"',
            'columns = "2..9"',
            "time_unit = 'min', 's', 'ms', 'us' or 'ns' wanted",
        ),
        ('time = "zeit_ms"\nunits = "ms"', 'columns = "2..9"', "unknown key 'units'"),
        ("rate_hz = 1", 'columns = "2..9"\ndims = ["taxel"]', '"time" and others of'),
    ],
)
def test_a_wrong_layout_is_refused_with_what_is_there(tmp_path: Path, top: str, finger: str, message: str) -> None:
    interleaved(tmp_path / "a.csv")
    with pytest.raises(InputError) as caught:
        read_foreign(tmp_path / "a.csv", layout_of(top, finger))
    assert message in str(caught.value)


def test_a_foreign_table_without_a_layout_names_the_way_in(tmp_path: Path) -> None:
    (tmp_path / "f.csv").write_text("t,x,y,z\n0,1,2,3\n0.01,1,2,3\n")
    result = call("run", tmp_path / "f.csv")
    assert result.exit_code == 2
    assert "it has t, x, y, z; `tactile layout f.csv -o layout.toml` writes a layout" in result.stderr
    np.save(tmp_path / "a.npy", FORCE)
    (tmp_path / "notes.md").write_text("#")
    result = call("run", tmp_path)
    assert result.exit_code == 2
    for name, why in (
        ("f.csv", "no header of a recording"),
        ("a.npy", "a table of another program"),
        ("notes.md", "suffix"),
    ):
        assert f"{name}: passed over, {why}" in result.stderr


def test_a_folder_of_takes_runs_by_its_layout(tmp_path: Path) -> None:
    for name in ("a.csv", "b.csv"):
        interleaved(tmp_path / name)
    (tmp_path / "labels.txt").write_text("grasp\n")
    call("layout", tmp_path, "-o", tmp_path / "layout.toml")
    with (tmp_path / "layout.toml").open("a") as file:
        file.write("")
    changed = (tmp_path / "layout.toml").read_text().replace("[layout]", '[layout]\nfiles = "*.csv"')
    (tmp_path / "layout.toml").write_text(changed)
    result = call("run", tmp_path, "--json")
    assert result.exit_code == 0, result.output
    found = json.loads(result.stdout)
    assert [(one["recording"], one["frames"]) for one in found["recordings"]] == [("a.csv", N), ("b.csv", N)]


def test_times_without_a_header_and_texts(tmp_path: Path) -> None:
    rows = "\n".join(f"2024-05-01 12:00:00.{k:02d},{k},{2 * k},ok" for k in range(10, 30))
    (tmp_path / "a.csv").write_text(rows + "\n")
    table = read_table(tmp_path / "a.csv")
    assert list(table.columns) == ["0", "1", "2", "3"]
    assert np.diff(table.columns["0"]).tolist() == [10**7] * 19
    with pytest.raises(InputError, match="has texts in it, such as 'ok'"):
        table.numbers(3, "columns")
    (tmp_path / "b.csv").write_text("only words\nand more words\n")
    with pytest.raises(InputError, match="no lines of numbers in it"):
        read_table(tmp_path / "b.csv")
