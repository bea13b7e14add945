"""The site: generated pages, links to them, and tutorials whose code, files and commands are executed in order."""

import re
import shlex
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
PAGES = [path for path in sorted(DOCS.glob("**/*.md")) if "generated" not in path.parts]
TUTORIALS = [path for path in sorted(DOCS.glob("tutorials/*.md")) if path.stem != "index"]
TUTORIALS.append(DOCS / "how-to" / "arrays.md")
GROUPS = {"cnnsim": cnnsim, "tactile": tactile}


@pytest.fixture(scope="module")
def generated(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return a folder with all generated pages."""
    with pytest.MonkeyPatch.context() as patch:
        patch.syspath_prepend(str(DOCS))
        from site_pages import write_generated_pages  # type: ignore[import-not-found]  # no package

        folder = tmp_path_factory.mktemp("docs") / "generated"
        write_generated_pages(folder)
        for name in ("site_pages", "library_pages", "notebook_pages"):
            del sys.modules[name]
    return folder


def test_each_template_has_a_page_with_pictures_and_code(generated: Path) -> None:
    pages = {path.stem: path.read_text(encoding="utf-8") for path in (generated / "library").glob("*.md")}
    assert pages.keys() == {"index", *library.names()}
    for name in library.names():
        assert f'cnnsim.run("{name}", picture' in pages[name]
        for picture in re.findall(r"!\[[^]]*\]\(([^)]+)\)", pages[name]):
            assert (generated / "library" / picture).is_file()
    assert "hole-filler-output.png" in pages["hole-filler"]
    assert len(list((generated / "library" / "programs").glob("*.md"))) >= 35


def test_each_notebook_is_a_page_with_its_pictures(generated: Path) -> None:
    for notebook in sorted((ROOT / "examples" / "notebooks").glob("*.ipynb")):
        page = (generated / "notebooks" / f"{notebook.stem}.md").read_text(encoding="utf-8")
        pictures = re.findall(r"!\[[^]]*\]\(([^)]+)\)", page)
        assert pictures
        assert all((generated / "notebooks" / picture).is_file() for picture in pictures)


def test_links_to_generated_pages_lead_somewhere(generated: Path) -> None:
    count = 0
    for page in PAGES:
        for target in re.findall(r"\]\([^)#:]*generated/([^)#:]+)", page.read_text(encoding="utf-8")):
            assert (generated / target).is_file(), f"{page.name}: {target}"
            count += 1
    assert count >= 4


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
