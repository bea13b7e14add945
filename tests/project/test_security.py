"""What SECURITY.md promises of the code: no eval, no exec, no pickle, no network; bags are read in another process."""

import ast
import subprocess
import sys
from collections.abc import Set
from pathlib import Path

from tests.kits.paths import ROOT

FILES = sorted(path for folder in ("cnnsim", "tactile") for path in (ROOT / folder).rglob("*.py"))
ALLOWED = {
    "cnnsim/support/extras.py": {"urllib"},  # taking an address apart
    "tactile/output/publish.py": {"urllib", "socket"},  # sends to the address that --publish names
}
REFUSED = {"pickle", "shelve", "marshal", "socket", "socketserver", "http", "urllib", "requests", "ftplib", "smtplib"}


def faults(source: str, allowed: Set[str] = frozenset()) -> list[str]:
    """Return what a source calls, imports or passes although SECURITY.md rules it out."""
    found, refused = [], REFUSED - allowed
    for node in ast.walk(ast.parse(source)):
        if isinstance(node, ast.Call) and isinstance(node.func, ast.Name):
            found += [node.func.id] if node.func.id in ("eval", "exec", "__import__") else []
        if isinstance(node, ast.Import):
            found += [name.name for name in node.names if name.name.split(".")[0] in refused]
        if isinstance(node, ast.ImportFrom):
            found += [node.module] if node.module and node.module.split(".")[0] in refused else []
        if isinstance(node, ast.keyword) and node.arg in ("allow_pickle", "shell"):
            found += [] if isinstance(node.value, ast.Constant) and node.value.value is False else [node.arg]
    return found


def test_nothing_is_executed_unpickled_or_sent() -> None:
    names = {path: path.relative_to(ROOT).as_posix() for path in FILES}
    found = {
        name: faults(path.read_text(encoding="utf-8"), ALLOWED.get(name, frozenset())) for path, name in names.items()
    }
    assert {name: wrong for name, wrong in found.items() if wrong} == {}


def test_what_is_ruled_out_is_found() -> None:
    bad = "eval('1')\nexec('')\nimport os, pickle\nfrom http.server import x\nf(allow_pickle=True)\nf(shell=yes)\n"
    assert sorted(faults(bad + "f(allow_pickle=False, shell=False)\nimport os\nfrom . import x\n")) == [
        "allow_pickle",
        "eval",
        "exec",
        "http.server",
        "pickle",
        "shell",
    ]
    assert faults("import urllib.parse", {"urllib"}) == []
    assert len(FILES) > 300


def test_the_library_that_makes_code_of_bags_is_never_in_this_process(tmp_path: Path) -> None:
    code = (
        "import sys, pathlib\n"
        "from cnnsim.support import InputError\n"
        "from tactile.sources import open_source\n"
        "path = pathlib.Path(sys.argv[1]); path.write_bytes(b'#ROSBAG V2.0\\n' + bytes(5000))\n"
        "try: open_source(path)\n"
        "except InputError as error: assert 'cannot be read as a ROS bag' in str(error), error\n"
        "else: raise SystemExit('taken')\n"
        "assert not any(name.split('.')[0] == 'rosbags' for name in sys.modules)\n"
    )
    command = [sys.executable, "-c", code, str(tmp_path / "no.bag")]
    done = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
