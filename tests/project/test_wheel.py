"""The wheel is complete: installed into an empty environment, it runs a template in another folder."""

import os
import subprocess
import sys
import venv
from pathlib import Path

from tests.kits.paths import ROOT

_OURS = {"PYTHONPATH", "PYTHONDONTWRITEBYTECODE"}
"""Variables that lead out of the empty environment, or make every process compile its libraries again."""


def _call(*command: str | Path, cwd: Path) -> "subprocess.CompletedProcess[str]":
    outside = {name: value for name, value in os.environ.items() if name not in _OURS}
    env = {**outside, "PIP_DISABLE_PIP_VERSION_CHECK": "1", "XDG_CACHE_HOME": str(cwd / "cache")}
    return subprocess.run(
        [str(part) for part in command], cwd=cwd, env=env, capture_output=True, text=True, check=False
    )


def _run(*command: str | Path, cwd: Path) -> str:
    done = _call(*command, cwd=cwd)
    assert done.returncode == 0, done.stdout + done.stderr
    return done.stdout


def test_a_wheel_in_an_empty_environment_runs_a_template(tmp_path: Path) -> None:
    _run(sys.executable, "-m", "build", "--no-isolation", "--wheel", "--outdir", tmp_path, ROOT, cwd=tmp_path)
    (wheel,) = tmp_path.glob("*.whl")
    venv.create(tmp_path / "empty")
    python = tmp_path / "empty" / "bin" / "python"
    pip = (
        sys.executable,
        "-m",
        "pip",
        "--python",
        python,
        "install",
        "--quiet",
        "--no-compile",
    )  # what is run is compiled
    _run(*pip, "--require-hashes", "-r", ROOT / "run.lock", cwd=tmp_path)
    _run(*pip, "--no-deps", wheel, cwd=tmp_path)
    script = (
        "import cnnsim, numpy as np\n"
        "from pathlib import Path\n"
        f"assert not Path(cnnsim.__file__).is_relative_to({str(ROOT)!r})\n"
        "square = -np.ones((5, 5)); square[1:4, 1:4] = 1\n"
        "y = cnnsim.run('edge', square).y\n"
        "print(int((y > 0).sum()), len(cnnsim.library.names()), cnnsim.__version__)\n"
    )
    black, names, version = _run(python, "-c", script, cwd=tmp_path).split()
    assert int(black) == 8
    assert int(names) == len(list((ROOT / "templates").glob("*.toml")))
    assert "edge" in _run(tmp_path / "empty" / "bin" / "cnnsim", "show", "edge", cwd=tmp_path)
    assert f"-{version}-" in wheel.name
    program = "from cnnsim import load_program; print(load_program('opening').name)"
    assert "opening" in _run(python, "-c", program, cwd=tmp_path)
    _examples_without_extras(tmp_path, wheel)


def _examples_without_extras(folder: Path, wheel: Path) -> None:
    """Both command lines write the examples; one runs, and what wants an extra says so in a line."""
    programs = folder / "empty" / "bin"
    for program in ("cnnsim", "tactile"):
        _run(programs / program, "examples", folder / program, cwd=folder)
    here = folder / "tactile"
    written = {path.relative_to(here) for path in here.rglob("*") if path.is_file()}
    assert {
        Path("README.md"),
        Path("examples/grasp.npz"),
        Path("examples/scenes/grip.toml"),
        Path("docs/detectors.md"),
    } <= written
    assert written == {path.relative_to(folder / "cnnsim") for path in (folder / "cnnsim").rglob("*") if path.is_file()}
    assert _run(programs / "python", "examples/edge_of_a_picture.py", cwd=here)
    wanting: dict[str, tuple[str | Path, ...]] = {
        "fem": (programs / "tactile", "run", "examples/scenes/bump.toml"),
        "opencl": (programs / "cnnsim", "run", "edge", "examples/scan.png", "-o", "edge.png", "--backend", "opencl"),
        "serial": (programs / "tactile", "convert", "examples/grasp.npz", "grasp.mcap"),
        "studio": (programs / "cnnsim", "studio", "--no-browser"),
        "video": (programs / "cnnsim", "run", "edge", "examples/scan.png", "-o", "rim.png", "--trajectory", "rim.mp4"),
    }
    for extra, call in wanting.items():
        done = _call(*call, cwd=here)
        assert done.returncode == 2, done.stdout
        assert len(done.stderr.strip().splitlines()) == 1, done.stderr
        assert f"pip install '{wheel}[{extra}]'" in done.stderr
    figure = _call(programs / "python", "-m", "examples.paper", "10", cwd=here)
    assert figure.stderr.strip() == f"left out: fig10_deformation: finite elements wanted: pip install '{wheel}[fem]'"
