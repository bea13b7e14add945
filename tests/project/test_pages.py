"""Files, commands and code that the pages name exist."""

import re
import shlex
import socket
import threading
from importlib import import_module
from pathlib import Path
from typing import Any

import click
import numpy as np
import pytest
from click.testing import CliRunner
from PIL import Image

from cnnsim import write_picture
from cnnsim.cli.group import main as cnnsim
from tactile.cli.group import main as tactile
from tactile.output.event_data import EventData
from tactile.output.publish import Publisher
from tactile.output.stream_frame import frame_data
from tests.kits.paths import FILE_PAGES, ROOT, SCENES

SITE = [ROOT / "docs", *(ROOT / "docs" / name for name in ("tutorials", "how-to", "reference", "explanation"))]
PAGES = [
    *sorted(ROOT.glob("*.md")), *(page for folder in SITE for page in sorted(folder.glob("*.md"))),
    *FILE_PAGES,
]  # fmt: skip
MODULES = sorted(path for folder in ("cnnsim", "tactile", "tests") for path in (ROOT / folder).rglob("*.py"))
ENTRY_POINTS = {"cnnsim.cellwise"}
"""What pyproject.toml calls so."""
GROUPS: dict[str, click.Group] = {"cnnsim": cnnsim, "tactile": tactile}


def _blocks(page: Path, *languages: str) -> list[str]:
    text = page.read_text(encoding="utf-8")
    return [code for language, code in re.findall(r"```(\w*)\n(.*?)```", text, re.DOTALL) if language in languages]


def _commands() -> list[str]:
    lines = [
        line.split("#")[0].strip() for page in PAGES for block in _blocks(page, "sh", "") for line in block.splitlines()
    ]
    return sorted({line for line in lines if line.split(" ")[0] in GROUPS})


def test_links_lead_somewhere() -> None:
    for page in PAGES:
        text = page.read_text(encoding="utf-8")
        for target in re.findall(r"\]\(([^)#:]+)\)", text):
            if "generated" not in target:  # those are pages of the site, which tests/project/test_site.py checks
                assert (page.parent / target).exists(), f"{page.name}: {target}"
        for anchor in re.findall(r"\]\(#([^)]+)\)", text):
            title = anchor.replace("-", "[ -]")  # a space of the title is a hyphen of the link
            assert re.search(rf"^#+ {title}$", text, re.MULTILINE | re.IGNORECASE), f"{page.name}: {anchor}"


def test_paths_that_a_page_names_are_there() -> None:
    named = r"(?<![\w/.-])((?:cnnsim|tactile|templates|tests|docs|examples)/[\w./-]*\w)"
    for page in PAGES:
        for path in re.findall(named, page.read_text(encoding="utf-8")):
            assert (ROOT / path).exists(), f"{page.name}: {path}"


def _is_there(name: str) -> bool:
    """Return whether a dotted name is a module or an attribute of one."""
    parts = name.split(".")
    modules = (count for count in range(len(parts), 0, -1) if _is_module(ROOT.joinpath(*parts[:count])))
    found: Any = import_module(".".join(parts[: (count := next(modules))]))
    for part in parts[count:]:
        if part in getattr(found, "__annotations__", {}):  # a field without a default
            return True
        if not hasattr(found, part):
            return False
        found = getattr(found, part)
    return True


def _is_module(path: Path) -> bool:
    return (path / "__init__.py").is_file() or path.with_suffix(".py").is_file()


def test_what_docstrings_and_pages_point_to_is_there() -> None:
    told = [page for page in PAGES if page.name != "CHANGELOG.md"]  # which tells of the past
    texts = [path.read_text(encoding="utf-8") for path in (*MODULES, *told)]
    names = {name for text in texts for name in re.findall(r"`((?:cnnsim|tactile|tests)(?:\.\w+)+)`", text)}
    assert len(names) > 20
    wrong = [
        name for name in names
        if not name.endswith((".py", ".md", ".toml")) and name not in ENTRY_POINTS and not _is_there(name)
    ]  # fmt: skip
    assert not wrong


def test_files_to_touch_stand_in_the_folder_to_open() -> None:
    rows = [row.split("|") for row in (ROOT / "CONTRIBUTING.md").read_text(encoding="utf-8").splitlines()]
    tasks = [(row[2].strip(" `"), re.findall(r"`(\w+\.py)`", row[3])) for row in rows if len(row) == 5]
    assert sum(len(files) for _, files in tasks) >= 10
    for folder, files in tasks:
        for file in files:
            assert (ROOT / folder / file).is_file() or file == "backend.py", f"{folder}{file}"


def test_the_python_of_the_readme_runs(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "examples").symlink_to(ROOT / "examples")
    write_picture(np.where(np.random.default_rng(1).random((24, 24)) < 0.5, 1.0, -1.0), "scan.png")
    names: dict[str, Any] = {}
    for block in _blocks(ROOT / "README.md", "python"):
        exec(compile(block, "README.md", "exec"), names)
    assert (tmp_path / "edge.png").is_file()
    assert names["warm"].t == 5.0
    assert names["touch"].events[-1].words == "release"


def test_the_python_of_the_page_on_control_loops_runs(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "examples").symlink_to(ROOT / "examples")
    names: dict[str, Any] = {}
    for block in _blocks(ROOT / "docs" / "python-and-control-loops.md", "python"):
        exec(compile(block, "python-and-control-loops.md", "exec"), names)
    assert [finger for _, finger, _ in names["commands"]] == ["left", "right"]  # both slip once
    assert capsys.readouterr().out.splitlines()[-1] == "2"
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as probe:
        probe.bind(("127.0.0.1", 0))
        port = probe.getsockname()[1]
    got: list[Any] = []
    reader = threading.Thread(target=lambda: got.append(next(names["datagrams"](port))), daemon=True)
    reader.start()
    frame, sender = names["frame"], Publisher(f"udp://:{port}", ())
    for _ in range(100):
        sender(frame, frame_data(frame, EventData(())))
        reader.join(0.02)
        if got:
            break
    sender.close()
    assert (got[0]["finger"], got[0]["sequence"]) == (frame.finger, frame.sequence)


def test_the_python_of_the_page_on_exports_reads_a_learning_set(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    pytest.importorskip("pyarrow", reason="needs pyarrow")
    monkeypatch.chdir(tmp_path)
    recording = ROOT / "examples" / "grasp.npz"
    done = CliRunner().invoke(tactile, ["convert", str(recording), "--lerobot", "learning-set"])
    assert done.exit_code == 0, done.output
    (block,) = _blocks(ROOT / "docs" / "export.md", "python")
    names: dict[str, Any] = {}
    exec(compile(block, "export.md", "exec"), names)
    assert names["taxels"].shape == (180, 4, 3)
    assert abs(names["unix_s"][names["slips"]][0] - 3.0) < 0.1
    assert "first slip at" in capsys.readouterr().out


def test_commands_are_understood() -> None:
    """Their names, arguments and options are; they are not run."""
    for name, *arguments in map(shlex.split, _commands()):
        group = GROUPS[name]
        position = next(i for i, argument in enumerate(arguments) if argument in group.commands)
        with group.make_context(name, list(arguments)) as outer:
            command = group.commands[arguments[position]]
            assert command.make_context(command.name, arguments[position + 1 :], parent=outer), arguments


def test_the_picture_of_the_readme_is_what_the_main_job_draws(tmp_path: Path) -> None:
    done = CliRunner().invoke(tactile, ["run", str(SCENES / "grip.toml"), "-o", str(tmp_path)])
    assert done.exit_code == 0, done.output
    pictures = tmp_path / "touch.png", ROOT / "examples" / "grip.png"
    drawn, shown = (np.asarray(Image.open(path).convert("L"), float) for path in pictures)
    assert drawn.shape == shown.shape
    assert np.abs(drawn - shown).mean() < 0.3  # another event, or words elsewhere, and it is more; of 255
