"""Where the tests find files of the project, and recordings that lie beside it."""

from pathlib import Path

ROOT = Path(__file__).parents[2]
SCENES = ROOT / "examples" / "scenes"
DATA = ROOT.parent / "shared" / "data"
"""Not part of the project: tests that use it are skipped where it is absent."""
