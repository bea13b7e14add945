"""The wheel carries all it needs: built, installed into an empty environment, it runs a template from elsewhere."""

import os
import subprocess
import sys
import venv
from pathlib import Path

from tests.kits.paths import ROOT


def _run(*command: str | Path, cwd: Path) -> str:
    outside = {name: value for name, value in os.environ.items() if name != "PYTHONPATH"}
    env = {**outside, "PIP_DISABLE_PIP_VERSION_CHECK": "1"}
    done = subprocess.run(
        [str(part) for part in command], cwd=cwd, env=env, capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stdout + done.stderr
    return done.stdout


def test_a_wheel_in_an_empty_environment_runs_a_template(tmp_path: Path) -> None:
    _run(sys.executable, "-m", "build", "--no-isolation", "--wheel", "--outdir", tmp_path, ROOT, cwd=tmp_path)
    (wheel,) = tmp_path.glob("*.whl")
    venv.create(tmp_path / "empty", with_pip=True)
    python = tmp_path / "empty" / "bin" / "python"
    _run(python, "-m", "pip", "install", "--quiet", "--require-hashes", "-r", ROOT / "run.lock", cwd=tmp_path)
    _run(python, "-m", "pip", "install", "--quiet", "--no-deps", wheel, cwd=tmp_path)
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
