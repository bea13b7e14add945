"""No file, however broken or hostile, ends in a traceback, takes 5 seconds or a gigabyte."""

import json
import mmap
import os
import subprocess
import sys
import threading
import time
from contextlib import suppress
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner
from PIL import Image

from cnnsim.cli.group import main as cnnsim
from cnnsim.support import InputError
from cnnsim.support.limits import TAXELS, check_unpacked
from cnnsim.support.pictures.picture import write_picture
from tactile.cli.group import main as tactile
from tactile.core.frame import TaxelArray
from tests.fuzz.broken_files import PARTS
from tests.fuzz.guarded import LIMIT, Guard, Verdict
from tests.fuzz.readers import BY_NAME
from tests.kits.paths import ROOT, SCENES

RECORDINGS = (".csv", ".npz", ".npy", ".parquet", ".mcap")


@pytest.mark.parametrize("parts", [("bags",), tuple(part for part in PARTS if part != "bags")], ids=["bags", "others"])
def test_all_readers_take_all_broken_files(parts: tuple[str, ...]) -> None:
    """Bags in a process of their own: the gigabyte that is theirs has no place for the other readers' libraries."""
    done = subprocess.run([sys.executable, "-m", "tests.fuzz.taken", "3", *parts], cwd=ROOT, capture_output=True,
                          text=True, check=False)  # fmt: skip
    assert done.returncode == 0, done.stderr[-2000:]
    found = json.loads(done.stdout)
    bad = [line for one in found.values() for line in one["bad"]]
    assert not bad, "\n".join(bad[:20])
    kinds = (
        {"b.bag", "good.db3", "metadata.yaml"} if parts == ("bags",) else {*BY_NAME, *(f"r{end}" for end in RECORDINGS)}
    )
    assert kinds <= set(found)
    assert all(one["files"] > 9 for name, one in found.items() if not name.startswith("bomb"))


def test_a_file_that_hangs_or_ends_its_process_costs_itself_alone(tmp_path: Path) -> None:
    def judge(path: Path) -> Verdict:
        if path.name == "hang":
            while True:
                pass
        if path.name == "wait":
            time.sleep(60)
        if path.name == "end":
            os._exit(3)
        if path.name == "large":
            mmap.mmap(-1, 2**25).write(b"x" * 2**25)  # never memory that was free already
        if path.name == "huge":
            bytearray(2 * LIMIT)
        return Verdict(read=True)

    guard = Guard(judge, slow=0.3, stuck=1.0, large=2**24)
    try:
        said = {
            name: guard.judge(tmp_path / name).faults
            for name in ("a", "hang", "b", "wait", "end", "large", "huge", "c")
        }
    finally:
        guard.close()
    assert [said[name] for name in "abc"] == [[], [], []]
    assert "s of the processor" in said["hang"][0]
    assert "not done" in said["wait"][0]
    assert said["end"] == ["the process ended with 3"]
    assert "MB" in said["large"][-1]
    assert said["huge"][0].startswith("the process ended")


@pytest.mark.parametrize("command", [
    ["cnnsim", "run", "edge", "p.png", "--step", "1e-300"], ["cnnsim", "run", "edge", "p.png", "--step", "nan"],
    ["cnnsim", "run", "edge", "p.png", "--time", "1e308"], ["cnnsim", "run", "diffusion", "p.png", "--step", "1e308"],
    ["cnnsim", "run", "edge", "p.png", "--boundary", "fixed:1e999"],
    ["cnnsim", "explain", "edge", "--size", "9e9x9"], ["cnnsim", "program", "p.png"],
    ["tactile", "run", "grip.toml", "--window", "1000000000"], ["tactile", "run", "grip.toml", "--window", "1e9"],
    ["tactile", "run", "p.png"], ["tactile", "convert", "p.png", "x.csv"], ["tactile", "calibrate", "p.png",
     "--speed-mm-s", "1", "--load-n", "1"], ["tactile", "explain", "p.png"], ["tactile", "replay", "p.png"],
])  # fmt: skip
def test_numbers_and_files_of_another_kind_end_in_one_line(
    command: list[str], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    write_picture(np.ones((4, 4)), tmp_path / "p.png")
    (tmp_path / "grip.toml").write_bytes((SCENES / "grip.toml").read_bytes())
    result = CliRunner().invoke({"cnnsim": cnnsim, "tactile": tactile}[command[0]], command[1:])
    assert result.exit_code == 2, result.output
    assert "Error" in result.stderr
    assert "Traceback" not in result.output


def test_a_message_is_a_line_of_bounded_length(tmp_path: Path) -> None:
    (tmp_path / "s.toml").write_text(f'title = 1\nseed = "{"x" * 50_000}"\n{"y" * 5000} = 1\n', encoding="utf-8")
    result = CliRunner().invoke(tactile, ["run", str(tmp_path / "s.toml")])
    assert result.exit_code == 2
    assert len(result.stderr) < 1100
    assert result.stderr.count("\n") == 1


def test_bounds_are_said_with_both_numbers(tmp_path: Path) -> None:
    with pytest.raises(InputError, match=f"1025 x 1024 taxels: 1049600; {TAXELS} at most wanted"):
        TaxelArray("tip", 1025, 1024, 1e-3, 1e-3)
    (tmp_path / "small").write_bytes(b"x" * 1000)
    check_unpacked(tmp_path / "small", 60_000_000)
    with pytest.raises(InputError, match="1000 bytes that unpack to 70000000; 200 times as many at most wanted"):
        check_unpacked(tmp_path / "small", 70_000_000)


@pytest.mark.parametrize(
    "words",
    [
        "tactile run p.mcap", "tactile run p.parquet", "tactile run p.npz", "tactile run p.csv", "tactile run p.toml",
        "tactile replay p.mcap", "tactile convert p.mcap o.npz", "tactile emulate --recording p.mcap",
        "tactile record -p no -a p.toml -o o.mcap", "cnnsim run edge p.png -o o.png",
        "cnnsim run p.toml p.png -o o.png", "cnnsim run edge p.mp4 -o o.mp4", "cnnsim import p.tem -o library",
    ],
)  # fmt: skip
def test_nobody_waits_for_a_pipe(words: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    for module in ("serial", "mcap", "pyarrow", "av"):
        pytest.importorskip(module, reason="every reader is tried")
    monkeypatch.chdir(tmp_path)
    command = words.split()
    (name,) = {word for word in command if word.startswith("p.")} - ({"p.png"} if "p.toml" in words else set())
    os.mkfifo(name)
    done, waited = threading.Event(), []

    def open_the_other_end() -> None:
        while not done.wait(4):
            with suppress(OSError):  # nobody is there
                os.close(os.open(name, os.O_WRONLY | os.O_NONBLOCK))
                waited.append(name)

    helper = threading.Thread(target=open_the_other_end)
    helper.start()
    try:
        result = CliRunner().invoke(cnnsim if command[0] == "cnnsim" else tactile, command[1:])
    finally:
        done.set()
        helper.join()
    assert not waited
    assert result.exit_code == 2
    assert "plain file" in result.output
    assert "Traceback" not in result.output


@pytest.mark.parametrize("name", ["p.png", "size.tif", "flags.dds"])
def test_whatever_pillow_raises_becomes_a_line(name: str, tmp_path: Path) -> None:
    """AssertionError without a word, TypeError and NotImplementedError."""
    path, grey = tmp_path / name, Image.new("P", (4, 4))
    if name == "p.png":  # a palette is wanted, and none is there
        grey.save(path)
        path.write_bytes(path.read_bytes().replace(b"PLTE", b"abCd"))
    elif name == "size.tif":  # the tag of the width is another's
        grey.convert("L").save(path)
        path.write_bytes(path.read_bytes().replace(b"\x00\x01\x04\x00", b"\x00\x7f\x04\x00", 1))
    else:
        grey.convert("RGB").save(path)
        path.write_bytes(path.read_bytes()[:80] + bytes(4) + path.read_bytes()[84:])
    result = CliRunner().invoke(cnnsim, ["run", "edge", str(path), "-o", str(tmp_path / "o.png")])
    assert result.exit_code == 2, result.output
    assert "is no picture that Pillow can read: " in result.stderr
    assert result.stderr.strip()[-1] != ":"


def test_a_pipe_and_an_empty_file_in_a_library_do_not_stop_it(tmp_path: Path) -> None:
    os.mkfifo(tmp_path / "pipe.toml")
    (tmp_path / "programs").mkdir()
    os.mkfifo(tmp_path / "programs" / "pipe.toml")
    (tmp_path / "empty.toml").touch()
    (tmp_path / "programs" / "empty.toml").touch()
    for more in ([], ["--programs"], ["--json"]):
        result = CliRunner().invoke(cnnsim, ["--library", str(tmp_path), "list", *more])
        assert result.exit_code == 0, result.output
        assert "edge" in result.stdout or "opening" in result.stdout
        assert "empty.toml" in result.output
