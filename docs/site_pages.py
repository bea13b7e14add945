"""Pages of the site that are made from other files: pages of the project's root, and the examples for the gallery."""

import builtins
import os
import re
import shutil
from pathlib import Path
from typing import Any

import numpy as np
from library_pages import write_library
from notebook_pages import write_notebooks

from cnnsim import run, write_picture

DOCS = Path(__file__).parent
ROOT = DOCS.parent
OUTER = {
    "CONVENTIONS.md": "conventions", "CHANGELOG.md": "changelog", "SECURITY.md": "security",
    "CONTRIBUTING.md": "contributing", "templates/README.md": "template-files",
    "templates/programs/README.md": "program-files", "tactile/CONNECT.md": "array-files",
    "tactile/wire/README.md": "serial-formats",
}  # fmt: skip
"""Pages outside of docs/ that belong to the site, and their names in docs/generated/."""
LONG = {"program_gallery", "a_locking_element", "where_a_strain_sensor_should_sit", "how_precise_must_a_chip_be"}
"""Examples that run for many seconds or take arguments; the gallery leaves them out."""
LINK = re.compile(r"\]\((?!\w+:|#|/)([^)#\s]+)(#[^)]*)?\)")


def write_generated_pages(folder: Path) -> None:
    """Write all generated pages into ``folder``, which is emptied first."""
    shutil.rmtree(folder, ignore_errors=True)
    folder.mkdir()
    for path, name in OUTER.items():
        text = (ROOT / path).read_text(encoding="utf-8")
        (folder / f"{name}.md").write_text(_relinked(text, (ROOT / path).parent, folder), encoding="utf-8")
    write_library(folder / "library")
    write_notebooks(ROOT / "examples" / "notebooks", folder / "notebooks", _relinked)
    _write_thumbnail(folder / "wave.png")
    _copy_examples(folder / "examples")


def outer_pages(app: Any, name: str, source: list[str]) -> None:
    """Rewrite the links of a page of docs/ that lead to a page outside of docs/; for Sphinx's event source-read."""
    at = (DOCS / name).parent
    if "generated" not in Path(name).parts:
        source[0] = _relinked(source[0], at, at)


def _relinked(text: str, origin: Path, target: Path) -> str:
    """Return a page with links that are relative to the folder ``target`` instead of ``origin``."""

    def link(found: re.Match[str]) -> str:
        path, anchor = (origin / found[1]).resolve(), found[2] or ""
        outer = path.relative_to(ROOT).as_posix() if path.is_relative_to(ROOT) else ""
        if outer == "README.md":
            path = DOCS / "index.md"
        elif outer in OUTER:
            path = DOCS / "generated" / f"{OUTER[outer]}.md"
        elif path.is_dir():
            return "](/index.md)"  # a folder has no page
        return f"]({os.path.relpath(path, target)}{anchor})"

    return LINK.sub(link, text)


def _write_thumbnail(path: Path) -> None:
    """Write the picture of the examples that draw none: the state of a diffusion that began with rings."""
    row, column = np.mgrid[-32:32, -48:48]
    rings = np.where(np.hypot(row, column) % 24 < 9, 1.0, -1.0)
    write_picture(run("diffusion", rings, duration=2.0).y, path, scale=4)


def _copy_examples(folder: Path) -> None:
    """Copy the examples with a title line, as sphinx-gallery reads them."""
    folder.mkdir()
    (folder / "GALLERY_HEADER.rst").write_text("Gallery\n=======\n\nShort programs, run when the site is built.\n")
    for path in sorted((ROOT / "examples").glob("*.py")):
        if path.stem in LONG | {"__init__"}:
            continue
        text = path.read_text(encoding="utf-8")
        _, docstring, code = text.split('"""', 2)
        title = path.stem.replace("_", " ").capitalize()
        (folder / path.name).write_text(
            f'r"""{title}\n{"=" * len(title)}\n\n{docstring.strip()}\n"""{code}', encoding="utf-8"
        )
    for path in (ROOT / "examples").glob("*.npz"):
        shutil.copy(path, folder)


def collect_pictures(block: Any, block_vars: dict[str, Any], gallery_conf: dict[str, Any]) -> str:
    """Return the reStructuredText of the pictures that an example has written; a scraper of sphinx-gallery."""
    from sphinx_gallery.scrapers import figure_rst

    found = []
    source = Path(block_vars["src_file"]).parent
    for path in sorted(path for kind in ("*.png", "*.gif") for path in source.glob(kind)):
        target = Path(next(block_vars["image_path_iterator"])).with_suffix(path.suffix)
        shutil.move(path, target)
        found.append(str(target))
    return figure_rst(found, gallery_conf["src_dir"]) if found else ""


def name_example(gallery_conf: dict[str, Any], name: str) -> None:
    """Define ``__file__`` of an example, which sphinx-gallery leaves undefined; called before each example."""
    builtins.__file__ = str(ROOT / "examples" / Path(name).name)  # type: ignore[attr-defined]  # looked up last


def escape_docstring(app: Any, what: str, name: str, found: Any, options: Any, lines: list[str]) -> None:
    """Escape | and * of formulas in a docstring outside of code; for Sphinx's event autodoc-process-docstring."""
    lines[:] = [_escaped(line) for line in lines]


def escape_help(app: Any, context: Any, lines: list[str]) -> None:
    """Escape | and * of formulas in a help text; for the events of sphinx-click."""
    lines[:] = [line if line.startswith((".. ", "   :")) else _escaped(line) for line in lines]


def _escaped(line: str) -> str:
    parts = re.split(r"(`[^`]*`+)", line)
    return "".join(part if part.startswith("`") else re.sub(r"(?<!\\)[|*]", r"\\\g<0>", part) for part in parts)
