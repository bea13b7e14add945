"""What SECURITY.md promises of the code: no eval, no exec, no pickle, no network; bags are read in another process."""

import ast
import subprocess
import sys
from pathlib import Path

import pytest

from tests.kits.paths import ROOT

FILES = sorted(path for folder in ("cnnsim", "tactile") for path in (ROOT / folder).rglob("*.py"))
ALLOWED = {
    "cnnsim/support/extras.py": {"urllib"},  # taking an address apart
}
REFUSED = {"pickle", "shelve", "marshal", "socket", "socketserver", "http", "urllib", "requests", "ftplib", "smtplib"}


@pytest.mark.parametrize("path", FILES, ids=lambda path: str(path.relative_to(ROOT)))
def test_nothing_is_executed_unpickled_or_sent(path: Path) -> None:
    refused = REFUSED - ALLOWED.get(path.relative_to(ROOT).as_posix(), set())
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(node, ast.Call) and isinstance(node.func, ast.Name):
            assert node.func.id not in ("eval", "exec", "__import__"), f"line {node.lineno}"
        if isinstance(node, ast.Import):
            assert not refused & {name.name.split(".")[0] for name in node.names}, f"line {node.lineno}"
        if isinstance(node, ast.ImportFrom):
            assert (node.module or "").split(".")[0] not in refused, f"line {node.lineno}"
        if isinstance(node, ast.keyword) and node.arg in ("allow_pickle", "shell"):
            assert isinstance(node.value, ast.Constant), f"line {node.value.lineno}"
            assert node.value.value is False, f"line {node.value.lineno}"


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
