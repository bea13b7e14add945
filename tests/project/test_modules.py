"""The packages run as modules and print their version."""

import subprocess
import sys

import pytest

import cnnsim
from tests.kits.paths import ROOT


@pytest.mark.parametrize("package", ["cnnsim", "tactile"])
def test_a_package_runs_as_a_module(package: str) -> None:
    for words, wanted in ((["--help"], f"Usage: python -m {package} "), (["--version"], cnnsim.__version__)):
        command = [sys.executable, "-m", package, *words]
        ran = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=True)
        assert wanted in ran.stdout
