"""Paths of the project's files, and of recordings outside the project."""

from pathlib import Path

ROOT = Path(__file__).parents[2]
SCENES = ROOT / "examples" / "scenes"
DATA = ROOT.parent / "shared" / "data"
"""Not part of the project: tests that use it are skipped where it is absent."""
