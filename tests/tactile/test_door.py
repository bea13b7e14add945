"""The public door: every name is there, and importing the package imports neither NumPy nor the machine."""

import subprocess
import sys
from collections.abc import Callable
from typing import Any

import pytest

import tactile
from tests.kits.paths import SCENES


def test_every_public_name_is_there() -> None:
    assert all(getattr(tactile, name) is not None for name in tactile.__all__)
    assert dir(tactile) == tactile.__all__
    with pytest.raises(AttributeError, match="no attribute 'roll'"):
        tactile.roll  # type: ignore[attr-defined]  # noqa: B018 - it is asked for


def test_importing_the_package_imports_nothing_slow() -> None:
    slow = "{'numpy', 'scipy', 'numba', 'cnnsim.network', 'cnnsim.support', 'tactile.pipeline'}"
    code = f"import sys, tactile; print(sorted({slow} & set(sys.modules)))"
    assert subprocess.check_output([sys.executable, "-c", code], text=True).strip() == "[]"


def test_a_scene_through_the_door() -> None:
    kinds: list[str] = []
    source = tactile.open_source(SCENES / "needle.toml")
    tactile.run(source, tactile.Settings(), [lambda report: kinds.extend(one.kind for one in report.events)])
    assert kinds == ["contact", "hold", "release"]


DOOR: Any = tactile  # what is wrong is tried, which types would refuse


@pytest.mark.parametrize(("wrong", "message"), [
    (lambda: DOOR.TaxelArray("a", 3.5, 5, 1e-3, 1e-3), "3.5 x 5 taxels"),
    (lambda: DOOR.TaxelArray("a", "3", 5, 1e-3, 1e-3), "two whole numbers and two lengths"),
    (lambda: DOOR.TaxelArray("a", 3, 5, "x", 1e-3), "pitch 'x'"),
    (lambda: DOOR.TaxelArray(1, 3, 5, 1e-3, 1e-3), "taxel array 1"),
    (lambda: DOOR.Settings(window="x"), "window 'x'; a whole number of frames wanted"),
    (lambda: DOOR.Settings(tare="sometimes"), "tare 'sometimes'; one of 'auto', 'manual', 'off'"),
    (lambda: DOOR.Settings(programs="two-blobs.toml"), "programs 'two-blobs.toml'; a tuple"),
    (lambda: DOOR.run("scene.toml", DOOR.Settings(), []), r"open_source\('scene.toml'\)"),
])  # fmt: skip
def test_what_is_no_value_of_the_doors_things_is_refused(wrong: Callable[[], Any], message: str) -> None:
    with pytest.raises(tactile.InputError, match=message):
        wrong()


def test_scenes_can_be_compared() -> None:
    array = tactile.TaxelArray("a", 2, 2, 1e-3, 1e-3)
    one, other = (tactile.MovingLoad(0, [[0.1, 0, 0, 0, 0, 0], [0.5, 0, 0, 0, 0, 0.2]]) for _ in range(2))
    scene = tactile.Scene("s", 100.0, 1.0, 2.4e6, (array,), (one,))
    assert scene == tactile.Scene("s", 100.0, 1.0, 2.4e6, (array,), (one,))
    assert scene != tactile.Scene("s", 100.0, 1.0, 2.4e6, (array,), (other,))
