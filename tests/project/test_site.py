"""The site: a build without output, and tutorials whose code, files and commands are executed in order."""

import re
import shlex
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest
from click.testing import CliRunner

from cnnsim import library
from cnnsim.cli.group import main as cnnsim
from tactile.cli.group import main as tactile
from tests.kits.paths import ROOT

DOCS = ROOT / "docs"
TUTORIALS = [path for path in sorted(DOCS.glob("tutorials/*.md")) if path.stem != "index"]
TUTORIALS.append(DOCS / "how-to" / "arrays.md")
GROUPS = {"cnnsim": cnnsim, "tactile": tactile}


def test_the_site_builds_without_a_warning(tmp_path: Path) -> None:
    """As `make docs`, but without output files and without running the gallery's examples."""
    command = [sys.executable, "-m", "sphinx", "-W", "--keep-going", "-q", "-D", "plot_gallery=0", "-b", "dummy"]
    built = subprocess.run([*command, str(DOCS), str(tmp_path)], capture_output=True, text=True, check=False)
    assert built.returncode == 0, built.stderr
    generated = DOCS / "generated"
    pages = {path.stem: path.read_text(encoding="utf-8") for path in (generated / "library").glob("*.md")}
    assert pages.keys() == {"index", *library.names()}
    for name in library.names():
        assert f'cnnsim.run("{name}", picture' in pages[name]
    assert "hole-filler-output.png" in pages["hole-filler"]
    assert len(list((generated / "library" / "programs").glob("*.md"))) >= 35
    for notebook in sorted((ROOT / "examples" / "notebooks").glob("*.ipynb")):
        page = (generated / "notebooks" / f"{notebook.stem}.md").read_text(encoding="utf-8")
        assert re.search(r"!\[[^]]*\]\(([^)]+)\)", page)


@pytest.mark.parametrize("page", TUTORIALS, ids=lambda page: page.stem)
def test_a_tutorial_runs_from_its_first_line_to_its_last(
    page: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Python is executed, commands are run, and a TOML block whose first line is a comment with a name is that file."""
    monkeypatch.chdir(tmp_path)
    (tmp_path / "examples").symlink_to(ROOT / "examples")
    names: dict[str, Any] = {}
    done = 0
    for language, code in re.findall(r"```(\w+)\n(.*?)```", page.read_text(encoding="utf-8"), re.DOTALL):
        if language == "python":
            exec(compile(code, page.name, "exec"), names)
        elif language == "toml":
            (tmp_path / code.splitlines()[0].strip("# ")).write_text(code)
        elif language == "sh":
            for line in code.splitlines():
                program, *arguments = shlex.split(line, comments=True)
                result = CliRunner().invoke(GROUPS[program], arguments)
                assert result.exit_code == 0, f"{line}\n{result.output}"
        done += language in ("python", "toml", "sh")
    assert done >= 4
