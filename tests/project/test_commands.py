"""Every command of README, CONNECT and the commands' own help runs unchanged."""

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
from importlib.util import find_spec
from pathlib import Path

import pytest
from click.testing import CliRunner

from cnnsim.cli.group import main as cnnsim
from tactile.cli.group import main as tactile
from tests.kits.own_files import write_own_files
from tests.kits.paths import FILE_PAGES, ROOT
from tests.kits.processes import command_line, ended

GROUPS = {"cnnsim": cnnsim, "tactile": tactile}
PORT = "/dev/ttyACM0"
SKIPPED = {  # by how a line begins
    "make ": "the makefile itself, which runs these tests; its targets are looked for below",
    "pip install": "no network; the extras are compared with pyproject.toml below",
    "cnnsim studio": "serves until Ctrl-C; tests/cnnsim/studio starts it",
    "tactile studio": "the same; tests/tactile/studio starts it",
    "CNNSIM_DEVICE=1": "a second device, which few machines have",
}
OPTIONAL = {"walk.mp4": "av", "cnnsim devices": "pyopencl", "tactile ports": "serial", ".parquet": "pyarrow",
            "--lerobot": "pyarrow",            ".mcap": "mcap", "tactile texture": "sklearn"}  # fmt: skip


def commands(path: Path) -> list[str]:
    """Return the commands on a page: lines of code blocks without a language or in sh, and of indented blocks."""
    text = path.read_text(encoding="utf-8")
    blocks = re.findall(r"^```(\w*)\n(.*?)^```$", text, re.DOTALL | re.MULTILINE)
    lines = [line for kind, block in blocks if kind in ("", "sh") for line in block.splitlines() if line.strip()]
    indented = re.findall(r"^ {4}((?:cnnsim|tactile|make|pip) .*)$", text, re.MULTILINE)
    return [*lines, *indented]


def epilog(group: str, name: str) -> list[str]:
    lines = (GROUPS[group].commands[name].epilog or "").splitlines()
    return [line.strip() for line in lines if line.startswith("  ")]


DOCS = [
    path.relative_to(ROOT).as_posix()
    for path in (*sorted(ROOT.glob("docs/*.md")), *sorted(ROOT.glob("docs/how-to/*.md")))
]
ALL_PAGES = ["README.md", "CONTRIBUTING.md", "CONVENTIONS.md", "SECURITY.md",
             *(page.relative_to(ROOT).as_posix() for page in FILE_PAGES), *DOCS]  # fmt: skip
PAGES = {page: lines for page in ALL_PAGES if (lines := commands(ROOT / page))}
HELP = {f"{group} {name}": epilog(group, name) for group, main in GROUPS.items() for name in main.commands}
LINES = list(
    dict.fromkeys(
        " ".join(line.split(" #")[0].split()) for lines in [*PAGES.values(), *HELP.values()] for line in lines
    )
)


READING = ("accuracy", "codes", "list", "score")
"""Commands that write no files without -o: a line of a page is not run again for the help."""


def runs_on_a_page(line: str) -> bool:
    """Return whether a line of the help is also on a page, and writes nothing that a later line of the help needs."""
    pages = {line.split(" #")[0].strip() for lines in PAGES.values() for line in lines}
    return line in pages and line.split()[1] in READING and " -o " not in line


def wants_port(line: str) -> bool:
    """Return whether a line needs a board or a recording of one."""
    return line.split()[1] in ("emulate", "live", "record") or "hand.mcap" in line


@pytest.fixture(scope="module")
def made(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """What `cnnsim examples` writes, and files with the names that the help takes for the reader's own."""
    folder = tmp_path_factory.mktemp("made")
    written = CliRunner().invoke(cnnsim, ["examples", str(folder)])
    assert written.exit_code == 0, written.output
    write_own_files(folder)
    return folder


@pytest.fixture
def folder(made: Path, tmp_path: Path) -> Path:
    """A copy of them."""
    return shutil.copytree(made, tmp_path / "here")


def run(line: str) -> None:
    program, *words = shlex.split(line, comments=True)
    done = CliRunner().invoke(GROUPS[program], words)
    assert done.exit_code == 0, f"{line}\n{done.output}"


def run_all(lines: list[str], folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Run the lines in their order, but for those of a port, whose test is below, and those of `SKIPPED`."""
    monkeypatch.chdir(folder)
    monkeypatch.setenv("COLUMNS", "100")
    left = []
    for line in lines:
        if line.startswith(tuple(SKIPPED)) or wants_port(line):
            continue
        missing = [library for name, library in OPTIONAL.items() if name in line and find_spec(library) is None]
        if missing:
            left.append(f"{line}: needs {', '.join(missing)}")
        else:
            run(line)
    if left:
        pytest.skip("; ".join(left))


@pytest.mark.parametrize("page", PAGES)
def test_the_commands_of_a_page_run_in_their_order(page: str, folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    run_all(PAGES[page], folder, monkeypatch)


@pytest.mark.parametrize("command", [name for name, lines in HELP.items() if lines])
def test_the_examples_in_the_help_run(command: str, folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    run_all([line for line in HELP[command] if not runs_on_a_page(line)], folder, monkeypatch)


def test_every_line_is_one_that_runs_or_has_a_reason_not_to() -> None:
    unknown = [line for line in LINES if line.split()[0] not in GROUPS and not line.startswith(tuple(SKIPPED))]
    assert not unknown
    assert not [start for start in SKIPPED if not any(line.startswith(start) for line in LINES)]
    assert {"README.md", "tactile/CONNECT.md"} <= PAGES.keys()


@pytest.mark.parametrize("page", ALL_PAGES)
def test_commands_and_options_within_the_text_are_there(page: str) -> None:
    text = (ROOT / page).read_text(encoding="utf-8")
    targets = re.findall(r"^([a-z-]+):", (ROOT / "Makefile").read_text(encoding="utf-8"), re.MULTILINE)
    assert {*re.findall(r"`make ([a-z-]+)", text)} <= {*targets}
    for program, words in re.findall(r"`(cnnsim|tactile) ([a-z-][^`]*)`", text):
        group, given = GROUPS[program], words.split()
        names = [word for word in given if word in group.commands]
        command = group.commands[names[0]] if names else group
        options = {name for one in (group, command) for option in one.params for name in option.opts}
        assert names, words
        assert {word for word in given if re.match(r"--?[a-z]", word)} <= options, words


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


def environment() -> dict[str, str]:
    return {**os.environ, "PYTHONPATH": str(ROOT)}


@contextmanager
def started(line: str, folder: Path) -> "Iterator[subprocess.Popen[str]]":
    command = command_line(*shlex.split(line, comments=True))
    with ended(subprocess.Popen(
        command, cwd=folder, env=environment(), stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, text=True
    )) as process:  # fmt: skip
        yield process


def first_word(process: "subprocess.Popen[str]", folder: Path) -> None:
    """Wait for what a device or a reader prints first, or for its recording."""
    assert process.stdout is not None
    until, before = time.monotonic() + 60, set(folder.glob("*.mcap*"))
    while time.monotonic() < until and process.poll() is None:
        if select.select([process.stdout], [], [], 0.1)[0] or set(folder.glob("*.mcap*")) - before:
            break
    time.sleep(0.3)


def stop(process: "subprocess.Popen[str]", line: str) -> None:
    process.send_signal(signal.SIGINT)
    told, _ = process.communicate(timeout=60)
    assert process.returncode == 0, f"{line}\n{told}"


def test_the_commands_of_a_port_run_on_an_emulated_one(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    pytest.importorskip("serial", reason="needs pyserial")
    lines = [line for line in LINES if line.split()[0] in GROUPS and wants_port(line)]
    emulated = {line: "pillars.port" if "papillarray" in line else "hand.port" for line in lines}
    live = {line.replace(PORT, port): port for line, port in emulated.items() if line.split()[1] in ("record", "live")}
    devices = [line for line in lines if line.split()[1] == "emulate"]
    (native,) = [line for line in devices if "--protocol native" in line]
    papillarray = native.replace("native", "papillarray").replace("hand.", "pillars.")
    assert live
    for line, port in live.items():
        emulate = papillarray if port == "pillars.port" else native
        if "hand.mcap" in line:  # each writes it again
            (folder / "hand.mcap").unlink(missing_ok=True)
        with started(emulate, folder) as device:
            first_word(device, folder)
            with started(line, folder) as reader:
                first_word(reader, folder)
                stop(reader, line)
            stop(device, emulate)
    monkeypatch.chdir(folder)
    run("tactile new scene my-touch")
    run("tactile new array my-skin -o skins")  # with a description of the reader's own
    for line in lines:
        if line.split()[1] in ("replay", "convert"):
            run(line)
    for line in devices:
        if line != native:
            with started(line, folder) as device:
                first_word(device, folder)
                stop(device, line)


def test_examples_do_not_replace_unasked(folder: Path) -> None:
    again = CliRunner().invoke(cnnsim, ["examples", str(folder)])
    assert again.exit_code == 2
    assert "files already" in again.output
    assert CliRunner().invoke(tactile, ["examples", str(folder), "--replace"]).exit_code == 0
