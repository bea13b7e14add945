"""Every command of README, CONNECT and the commands' own help runs as it stands, where the pages say that it does."""

import os
import re
import select
import shlex
import shutil
import signal
import subprocess
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner

from cnnsim import read_picture, write_picture
from cnnsim.cli.group import main as cnnsim
from cnnsim.support.extras import install_line
from tactile.cli.group import main as tactile
from tests.kits.example_files import PICTURE, RECORDING, SCENE, scan
from tests.kits.paths import ROOT
from tests.kits.processes import command_line, ended

GROUPS = {"cnnsim": cnnsim, "tactile": tactile}
PORT = "/dev/ttyACM0"
NOT_RUN = {
    "make ": "the makefile itself, which runs these tests",
    "pip install": "no network; the extras are compared with pyproject.toml below",
    "cnnsim devices": "what there is depends on the machine; tests/backends/opencl runs it",
    "CNNSIM_DEVICE=1": "the same",
    "tactile ports": "the same; tests/tactile/serial runs it",
    "tactile emulate": "runs until it is stopped: the test of the port runs it",
    "tactile live": "the same",
    "tactile record": "the same",
    "tactile replay": "the same, and what it has recorded",
    "tactile convert hand.mcap": "the same",
}


def blocks(path: Path) -> list[str]:
    text = path.read_text(encoding="utf-8")
    found = re.findall(r"^```(?:sh)?\n(.*?)^```", text, re.DOTALL | re.MULTILINE)
    return [line for block in found for line in block.splitlines() if line.strip()]


def epilog(group: str, name: str) -> list[str]:
    lines = (GROUPS[group].commands[name].epilog or "").splitlines()
    return [line.strip() for line in lines if line.startswith("  ")]


PAGES = {page: blocks(ROOT / page) for page in ("README.md", "tactile/CONNECT.md")}
HELP = {f"{group} {name}": epilog(group, name) for group, main in GROUPS.items() for name in main.commands}


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """What `cnnsim examples` writes, and files with the names that the help takes for the reader's own."""
    folder = tmp_path_factory.mktemp("commands")
    written = CliRunner().invoke(cnnsim, ["examples", str(folder)])
    assert written.exit_code == 0, written.output
    square, picture = np.pad(np.ones((9, 9)), 5, constant_values=-1), scan()
    for name in ("square", "before", "after"):
        write_picture(square if name != "after" else -square, folder / f"{name}.png")
    for name in ("scan.png", "photo.jpg", "photo.png", "f1.png", "f2.png", "frame1.png", "frame2.png", "frame3.png"):
        write_picture(picture, folder / name)
    for name in ("mask", "marker", "keep"):
        write_picture(abs(picture) * (1 if name == "mask" else -1), folder / f"{name}.png")
    for name in ("scans", "left", "right"):
        (folder / name).mkdir()
        for number in (1, 2):
            write_picture(picture, folder / name / f"{number}.png")
    (folder / "my-library").mkdir()
    (folder / "grasp.npz").write_bytes(RECORDING.read_bytes())
    (folder / "scene.toml").write_bytes(SCENE.read_bytes())
    return folder


def run(line: str, folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    if any(line.startswith(start) for start in NOT_RUN):
        return
    monkeypatch.chdir(folder)
    monkeypatch.setenv("COLUMNS", "100")
    program, *words = shlex.split(line, comments=True)
    done = CliRunner().invoke(GROUPS[program], words)
    assert done.exit_code == 0, f"{line}\n{done.output}"


@pytest.mark.parametrize("page", PAGES)
def test_the_commands_of_a_page_run_in_their_order(page: str, folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    lines = [line for line in PAGES[page] if line.split()[0] in ("cnnsim", "tactile")]
    assert lines
    for line in lines:
        run(line, folder, monkeypatch)


OWN_FILES = {  # files that only the reader can have; the reading of such files has tests of its own
    "walk.mp4", "my-program.toml", "rule.toml", "EDGE.tem", "temlib.m", "best.txt", "scan.csv", "grasp.csv",
    "grasp.npz", "labels.csv", "l.csv",
}  # fmt: skip


@pytest.mark.parametrize("command", [name for name, lines in HELP.items() if lines])
def test_the_examples_in_the_help_run(command: str, folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    shutil.rmtree(folder / "my-examples", ignore_errors=True)  # the README has them made, too
    for line in HELP[command]:
        if not any(own in line for own in OWN_FILES):
            run(line, folder, monkeypatch)


def test_every_command_has_examples_in_its_help() -> None:
    assert not [name for name, lines in HELP.items() if not lines]


def test_extras_that_are_named_are_there() -> None:
    project = (ROOT / "pyproject.toml").read_text(encoding="utf-8")
    named = {
        extra for lines in PAGES.values() for line in lines for found in re.findall(r"\[([\w,]+)\]'", line)
        for extra in found.split(",")
    }  # fmt: skip
    assert named >= {"serial", "opencl"}
    assert not [extra for extra in named if not re.search(rf"^{extra} = \[", project, re.MULTILINE)]


@pytest.mark.parametrize("extra", ["serial", "opencl", "fem", "video"])
def test_the_line_that_installs_an_extra_names_something_that_is_there(extra: str) -> None:
    line = install_line(extra)
    assert line.startswith("pip install ")
    place = re.search(rf"(/[^'\[]*)\[{extra}\]", line)
    assert place is None or Path(place[1]).exists()
    assert "cellular-wave-touch[" not in line.replace(str(ROOT), "")


def environment() -> dict[str, str]:
    return {**os.environ, "PYTHONPATH": str(ROOT)}


@contextmanager
def started(line: str, folder: Path) -> "Iterator[subprocess.Popen[str]]":
    command = command_line(*shlex.split(line, comments=True))
    with ended(subprocess.Popen(
        command, cwd=folder, env=environment(), stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, text=True
    )) as process:  # fmt: skip
        yield process


def first_word(reader: "subprocess.Popen[str]", folder: Path) -> None:
    """Wait for what a reader of a port prints first, or for its recording."""
    assert reader.stdout is not None
    until = time.monotonic() + 40
    before = set(folder.glob("*.mcap*"))
    while time.monotonic() < until and reader.poll() is None:
        if select.select([reader.stdout], [], [], 0.1)[0] or set(folder.glob("*.mcap*")) - before:
            break
    time.sleep(0.5)


def test_the_commands_of_a_port_run_on_an_emulated_one(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    pytest.importorskip("serial", reason="needs pyserial")
    lines = PAGES["tactile/CONNECT.md"]
    (emulate,) = [line for line in lines if "emulate" in line]
    (record,) = [line for line in lines if line.startswith("tactile record")]
    (live,) = [line for line in lines if line.startswith("tactile live -p hand.port")]
    for line in (record.replace(PORT, "hand.port"), live):
        with started(emulate, folder) as device:
            assert device.stdout is not None
            assert device.stdout.readline().strip()  # the port is there
            with started(line, folder) as reader:
                first_word(reader, folder)
                reader.send_signal(signal.SIGINT)
                told, _ = reader.communicate(timeout=30)
            assert reader.returncode == 0, told
            device.send_signal(signal.SIGINT)
            device.wait(timeout=30)
    for line in [line for line in lines if line.startswith(("tactile replay", "tactile convert"))]:
        monkeypatch.chdir(folder)
        done = CliRunner().invoke(tactile, shlex.split(line, comments=True)[1:])
        assert done.exit_code == 0, f"{line}\n{done.output}"


def test_example_files_are_what_the_code_makes(tmp_path: Path) -> None:
    from tactile.sources import open_source

    assert abs(read_picture(PICTURE) - scan()).max() <= 1 / 255
    assert RECORDING.stat().st_size < 300_000
    kept, made = open_source(RECORDING), open_source(SCENE)
    assert [array.name for array in kept.arrays] == [array.name for array in made.arrays]
    for ours, theirs in zip(kept, made, strict=True):
        assert abs(ours.values - theirs.values).max() < 1e-12
        if ours.t > 0.1:
            break


def test_examples_do_not_replace_unasked(folder: Path) -> None:
    again = CliRunner().invoke(cnnsim, ["examples", str(folder)])
    assert again.exit_code == 2
    assert "files already" in again.output
    assert CliRunner().invoke(tactile, ["examples", str(folder), "--replace"]).exit_code == 0
