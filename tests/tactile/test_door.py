"""The public door: every name is there, and importing the package imports neither NumPy nor the machine."""

import subprocess
import sys

import pytest

import tactile
from tests.kits.paths import SCENES


def test_every_public_name_is_there() -> None:
    assert all(getattr(tactile, name) is not None for name in tactile.__all__)
    assert dir(tactile) == tactile.__all__
    with pytest.raises(AttributeError, match="no attribute 'roll'"):
        tactile.roll  # noqa: B018 - it is asked for


def test_importing_the_package_imports_nothing_slow() -> None:
    code = "import sys, tactile; print(sorted({'numpy', 'cnnsim', 'scipy', 'tactile.pipeline'} & set(sys.modules)))"
    assert subprocess.check_output([sys.executable, "-c", code], text=True).strip() == "[]"


def test_a_scene_through_the_door() -> None:
    kinds: list[str] = []
    source = tactile.open_source(SCENES / "needle.toml")
    tactile.run(source, tactile.Settings(), [lambda report: kinds.extend(one.kind for one in report.events)])
    assert kinds == ["contact", "hold", "release"]
