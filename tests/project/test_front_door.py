"""The names of ``import cnnsim``: each exists and works, and the import loads no slow library."""

import ast
import pkgutil
import subprocess
import sys
from importlib import import_module
from pathlib import Path
from types import ModuleType

import numpy as np
import pytest

import cnnsim
import tactile
from cnnsim import InputError, Template, library
from cnnsim.backends import NAMES
from tests.kits.paths import ROOT

OFFERED = {
    "run", "run_program", "run_transient", "trajectory", "UniversalMachine", "load_program", "Program", "Template",
    "from_gray", "to_planes", "plot", "Trajectory", "accuracy", "design", "robust", "trace",
    "gradient", "train", "Training", "TrainingTask", "Stage",
    "Term", "LayeredTemplate", "Table", "Cell", "Frames", "Boundary", "fixed", "ZERO_FLUX", "PERIODIC", "explain",
    "library", "devices", "read_picture", "read_pictures", "write_picture",
    "Result", "Sides", "InputError", "NotSettledError", "__version__",
}  # fmt: skip

SQUARE = -np.ones((7, 7))
SQUARE[2:5, 2:5] = 1


def test_every_name_is_there_and_says_what_it_is() -> None:
    assert set(cnnsim.__all__) == OFFERED
    for name in OFFERED - {"__version__", "ZERO_FLUX", "PERIODIC"}:
        assert (getattr(cnnsim, name).__doc__ or "").strip(), name


@pytest.mark.parametrize("package", ["cnnsim", "tactile"])
def test_importing_a_package_loads_nothing_heavy(package: str) -> None:
    code = f"import sys, {package}; print(*sorted({{name.split('.')[0] for name in sys.modules}}))"
    loaded = subprocess.run([sys.executable, "-c", code], cwd=ROOT, capture_output=True, text=True, check=True)
    assert package in loaded.stdout.split()
    slow = {"numpy", "numba", "pyopencl", "matplotlib", "scipy", "click", "rich", "typing", "importlib.metadata"}
    assert not slow & set(loaded.stdout.split())


@pytest.mark.parametrize("package", [cnnsim, tactile])
def test_a_name_of_a_package_is_what_type_checkers_take_it_for(package: ModuleType) -> None:
    assert package.__file__ is not None
    tree = ast.parse(Path(package.__file__).read_text(encoding="utf-8"))
    imports = [one for one in ast.walk(tree) if isinstance(one, ast.ImportFrom) and one.module != "cnnsim.lazy"]
    declared = {name.name: one.module for one in imports for name in one.names}
    assert {*declared} - {"__version__"} == {*package.__all__} - {"__version__"}
    for name, module in declared.items():
        assert getattr(package, name) is getattr(import_module(str(module)), name), name


@pytest.mark.parametrize("package", [cnnsim, tactile])
def test_no_module_hides_a_name_of_its_package(package: ModuleType) -> None:
    modules = {one.name: one.ispkg for one in pkgutil.iter_modules(package.__path__)}
    hidden = [
        name for name in package.__all__ if name in modules and not isinstance(getattr(package, name), ModuleType)
    ]
    assert not hidden


@pytest.mark.parametrize("package", ["cnnsim", "tactile"])
def test_a_fresh_package_gives_all_its_names_and_its_folders_but_no_other(package: str) -> None:
    code = f"""
import {package}
from {package} import *
assert set(dir({package})) == set({package}.__all__) <= set(globals()), dir({package})
assert {package}.cli.__name__ == "{package}.cli"
try:
    {package}.ru
except AttributeError as error:
    print(error, error.name, error.obj is {package})
"""
    told = subprocess.run([sys.executable, "-c", code], cwd=ROOT, capture_output=True, text=True, check=True)
    assert told.stdout == f"module {package!r} has no attribute 'ru' ru True\n"


def test_a_program_runs_by_name_by_file_and_as_loaded() -> None:
    file = ROOT / "templates" / "programs" / "count-objects.toml"
    for program in ("count-objects", file, str(file), cnnsim.load_program("count-objects")):
        assert cnnsim.run_program(program, picture=SQUARE) == {"objects": 1}


def test_each_call_of_run_program_starts_with_what_the_file_says() -> None:
    program = cnnsim.load_program("motion-direction")
    for _ in range(2):
        assert not cnnsim.run_program(program, frame=SQUARE, backend="reference")["rest"].any()


def test_run_program_says_which_inputs_it_wants() -> None:
    with pytest.raises(InputError, match="got image; picture wanted"):
        cnnsim.run_program("opening", image=SQUARE)
    with pytest.raises(InputError, match="did you mean opening"):
        cnnsim.run_program("openning", picture=SQUARE)


def test_every_template_is_explained() -> None:
    for name in library.names():
        lines = str(cnnsim.explain(name)).splitlines()
        assert len(lines) >= 2, name
        assert lines[-1].startswith("guaranteed time "), name


def test_a_shape_and_a_picture_of_it_are_explained_alike() -> None:
    by_shape, by_picture = (cnnsim.explain(library.load("hole-filler"), picture) for picture in ((7, 7), SQUARE))
    assert str(by_shape) == str(by_picture)
    assert by_shape.plan.shape == (7, 7)
    assert by_shape.guaranteed == library.load("hole-filler").running_time((7, 7))


def test_programs_are_explained_by_name_file_and_value() -> None:
    path = library.folder() / "programs" / "skeleton.toml"
    told = [str(cnnsim.explain(what)) for what in ("skeleton", "programs/skeleton", str(path))]
    assert told[0] == told[1] == told[2] == str(cnnsim.explain(cnnsim.load_program("skeleton"), np.ones((64, 64))))
    assert "step 2.1: template skeleton-1" in told[0]
    assert "closed form" in told[0]
    assert "packed logic" in str(cnnsim.explain("programs/opening", (7, 9)))  # of a template of that name, too
    assert "runs no template" in str(cnnsim.explain("locate-strain"))
    with pytest.raises(InputError, match="duration: 'skeleton' is a program"):
        cnnsim.explain("skeleton", duration=3.0)
    with pytest.raises(InputError, match=r"no program 'edge', but a template"):
        cnnsim.explain("programs/edge")


def test_templates_of_ones_own_are_explained() -> None:
    heat = Template([[0.1, 0.15, 0.1], [0.15, 0, 0.15], [0.1, 0.15, 0.1]])
    found = cnnsim.explain(heat, (9, 9), duration=5.0, scheme="rk4")
    assert found.plan.scheme is not None
    assert found.plan.scheme.name == "rk4"
    assert found.guaranteed.time is None
    two = cnnsim.LayeredTemplate([heat, heat])
    assert "2 layers" in str(cnnsim.explain(two, (9, 9)))


def test_devices_are_values_and_none_without_opencl(monkeypatch: pytest.MonkeyPatch) -> None:
    for device in cnnsim.devices():
        assert device.compute_units >= 1
        assert device.type in ("cpu", "gpu", "accelerator")
    assert sum(device.chosen for device in cnnsim.devices()) == bool(cnnsim.devices())
    for module in [name for name in sys.modules if name.startswith("cnnsim.backends.opencl")]:
        monkeypatch.delitem(sys.modules, module)
    monkeypatch.delattr(cnnsim.backends, "opencl", raising=False)
    monkeypatch.setitem(sys.modules, "pyopencl", None)
    assert cnnsim.devices() == []


def test_the_backends_compute_the_same_program() -> None:
    wanted = cnnsim.run_program("opening", picture=SQUARE, backend="reference")
    for backend in NAMES:
        if backend == "opencl" and not cnnsim.devices():
            continue
        found = cnnsim.run_program("opening", picture=SQUARE, backend=backend)
        assert all(np.array_equal(found[name], wanted[name]) for name in wanted), backend
