"""Paths of the project's files, and of recordings outside the project."""

from pathlib import Path

ROOT = Path(__file__).parents[2]
FILE_PAGES = [
    ROOT / "templates" / "README.md", ROOT / "templates" / "programs" / "README.md",
    ROOT / "tactile" / "CONNECT.md", ROOT / "tactile" / "wire" / "README.md",
]  # fmt: skip
"""Pages on file formats, outside of docs/."""
SCENES = ROOT / "examples" / "scenes"
DATA = ROOT.parent / "shared" / "data"
"""Not part of the project: tests that use it are skipped where it is absent."""
