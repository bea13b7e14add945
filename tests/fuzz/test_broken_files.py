"""No file, however broken or hostile, ends in a traceback, takes 5 s of the processor or a gigabyte."""

import os
import resource
import signal
import threading
import warnings
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from click.testing import CliRunner
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from PIL import Image

from cnnsim.cli.group import main as cnnsim
from cnnsim.support import InputError
from cnnsim.support.limits import TAXELS, check_unpacked
from cnnsim.support.pictures.picture import write_picture
from tactile.cli.group import main as tactile
from tactile.core.frame import TaxelArray
from tests.fuzz.good_files import HUGE, TEXTS, good_files
from tests.fuzz.hostile_files import hostile_files
from tests.fuzz.readers import read
from tests.kits.paths import SCENES

for library in ("rosbags", "mcap", "pyarrow", "zarr"):
    pytest.importorskip(library, reason="every reader is tested")
EXAMPLES = int(os.environ.get("FUZZ_EXAMPLES", "8"))
"""Changes of each good file."""
SECONDS, BYTES = 5, 1000 * 2**20
"""What no file may take: time of the processor, and memory beyond what the process had."""


@st.composite
def changes(draw: Any, data: bytes, *, text: bool) -> bytes:
    """Draw a file that is cut short, has bytes replaced, inserted or removed; of a text also a value replaced."""
    kinds = ["cut", "replace", "insert", "remove", *(["value"] * 4 if text else [])]
    for _ in range(draw(st.integers(1, 3))):
        kind, at = draw(st.sampled_from(kinds)), draw(st.integers(0, len(data)))
        if kind == "value":
            lines = data.split(b"\n")
            number = draw(st.integers(0, len(lines) - 1))
            key, equals, _ = lines[number].partition(b"=")
            lines[number] = key + equals + draw(st.sampled_from(HUGE)).encode()
            data = b"\n".join(lines)
            continue
        piece = draw(st.binary(max_size=64))
        after = {"cut": len(data), "replace": at + len(piece), "insert": at, "remove": at + 1 + len(piece)}[kind]
        data = data[:at] + (piece if kind in ("replace", "insert") else b"") + data[after:]
    return data


@contextmanager
def within_limits() -> Iterator[None]:
    """Fail in a block that takes more of the processor or of the memory than a file may."""

    def late(*_: object) -> None:
        raise AssertionError(f"more than {SECONDS} s of the processor")

    before, peak = signal.signal(signal.SIGPROF, late), resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    signal.setitimer(signal.ITIMER_PROF, SECONDS)
    try:
        yield
    finally:
        signal.setitimer(signal.ITIMER_PROF, 0)
        signal.signal(signal.SIGPROF, before)
    assert 1024 * (resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - peak) < BYTES


def check_read(path: Path, data: bytes, *, own_process: bool = False) -> None:
    """Check that a file is read, or refused with a message."""
    path.write_bytes(data)
    with within_limits(), warnings.catch_warnings():
        warnings.simplefilter("ignore")
        try:
            read(path, own_process=own_process)
        except InputError as error:
            assert str(error)


@pytest.fixture(scope="module")
def good(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, dict[str, bytes]]:
    folder = tmp_path_factory.mktemp("good")
    files = good_files(folder)
    for name in ("good.db3", *files):  # what a reader loads counts for no file
        check_read(folder / name, files[name])
    return folder, files


NAMES = (*TEXTS, "r.csv", "r.npz", "r.parquet", "r.mcap", "p.png", "p.gif", "p.bmp", "p.tif", "p.jpg", "p.pgm", "r.npy",
         "large.npy", "heights.npy", "traction.npy", "body.stl", "model.npz", "slides.npz", "sequences.npz", "b.bag",
         "good.db3", "metadata.yaml", "film.mp4")  # fmt: skip


@pytest.mark.parametrize("name", NAMES)
def test_a_changed_file_is_read_or_refused(
    name: str, good: tuple[Path, dict[str, bytes]], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("CNNSIM_MEMORY", "500M")  # pictures may be as large as the free memory
    folder, files = good
    if name not in files:
        pytest.skip("its library is missing")

    @settings(max_examples=EXAMPLES, deadline=None, derandomize=True, database=None,
              suppress_health_check=list(HealthCheck))  # fmt: skip
    @given(changes(files[name], text=name in TEXTS))
    def run(data: bytes) -> None:
        check_read(folder / name, data)

    run()
    (folder / name).write_bytes(files[name])  # a bag and its description are read together


def test_hostile_files_are_refused(good: tuple[Path, dict[str, bytes]], monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("CNNSIM_MEMORY", "500M")
    folder, files = good
    for name, data in hostile_files():
        try:
            check_read(folder / name, data, own_process=True)
        except Exception as error:
            raise AssertionError(f"{name}, {len(data)} bytes: {data[:60]!r}") from error
        (folder / name).write_bytes(files[name])


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
            with suppress(OSError):  # no reader has the pipe open
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
