"""The choice of an OpenCL device, and what is said where there is none."""

import ctypes
import os
import platform
import re
import subprocess
import sys
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from click.testing import CliRunner

from cnnsim import InputError, backends
from cnnsim.cli.devices import devices
from cnnsim.library.explain import explain_template
from cnnsim.operations.cellwise import Cellwise

cl = pytest.importorskip("pyopencl", reason="the opencl backend needs pyopencl")

from cnnsim.backends.opencl import backend as opencl  # noqa: E402 - only where pyopencl is there
from cnnsim.backends.opencl.backend import OpenCLBackend  # noqa: E402
from cnnsim.backends.opencl.device import devices as opencl_devices  # noqa: E402
from cnnsim.backends.opencl.device import kernel_cache, pocl  # noqa: E402
from cnnsim.backends.opencl.planes import DevicePlane  # noqa: E402
from cnnsim.support.extras import install_line  # noqa: E402

if not opencl_devices.all_devices():
    pytest.skip("there is no OpenCL device", allow_module_level=True)


def test_float64_needs_a_device_that_has_it(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(opencl, "has_float64", lambda device: False)
    with pytest.raises(InputError, match="has no float64; use float32"):
        OpenCLBackend("float64")
    assert isinstance(OpenCLBackend("float32").load(np.zeros((1, 1)), "lam"), DevicePlane)
    with pytest.raises(InputError, match="float32 or float64, not in float16"):
        OpenCLBackend("float16")


def test_a_device_is_chosen_by_number_name_or_variable(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delenv(opencl_devices.VARIABLE, raising=False)
    first = opencl_devices.all_devices()[0]
    assert opencl_devices.choose_device(0) == first
    assert opencl_devices.choose_device(first.name[1:5].swapcase()) is not None
    with pytest.raises(InputError, match=r"no OpenCL device 99; known are 0: "):
        opencl_devices.choose_device(99)
    with pytest.raises(InputError, match=r"no OpenCL device is called 'zx81'; known are 0: "):
        opencl_devices.choose_device("zx81")
    monkeypatch.setenv(opencl_devices.VARIABLE, "0")
    assert OpenCLBackend().device == first
    monkeypatch.setenv(opencl_devices.VARIABLE, "zx81")
    with pytest.raises(InputError, match=r"'zx81' \(CNNSIM_DEVICE\)"):
        backends.get("opencl")


def test_without_a_platform_the_message_has_the_cure(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(cl, "get_platforms", list)
    with pytest.raises(InputError, match=r'no OpenCL device; pip install "pyopencl\[pocl\]"'):
        opencl_devices.choose_device()


def test_without_pyopencl_the_message_has_the_cure(monkeypatch: pytest.MonkeyPatch) -> None:
    for module in [name for name in sys.modules if name.startswith("cnnsim.backends.opencl")]:
        monkeypatch.delitem(sys.modules, module)
    monkeypatch.delattr(backends, "opencl", raising=False)
    monkeypatch.setitem(sys.modules, "pyopencl", None)
    with pytest.raises(InputError, match=re.escape(f"the opencl backend needs pyopencl: {install_line('opencl')}")):
        backends.get("opencl")
    assert "[opencl]" in str(CliRunner().invoke(devices).exception)


def test_devices_are_listed(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delenv(opencl_devices.VARIABLE, raising=False)
    text, data = CliRunner().invoke(devices), CliRunner().invoke(devices, ["--json"])
    assert text.exit_code == data.exit_code == 0
    assert f"0  {opencl_devices.all_devices()[0].name}" in text.output
    assert '"chosen": true' in data.output


def test_the_processor_name_is_replaced_only_on_request(monkeypatch: pytest.MonkeyPatch) -> None:
    """A device whose record lies in memory of our own: a field that points to the name, before it one that does not."""
    name = ctypes.create_string_buffer(b"generic")
    record = (ctypes.c_uint64 * 512)(0, ctypes.addressof(name))
    text = SimpleNamespace(name="Portable Computing Language")
    device: Any = SimpleNamespace(
        platform=text, version="OpenCL 3.0 PoCL HSTR: pthread-x86_64-generic", int_ptr=ctypes.addressof(record)
    )
    monkeypatch.setattr(platform, "machine", lambda: "x86_64")
    monkeypatch.delenv(pocl.VARIABLE, raising=False)
    pocl.name_processor(device)
    assert name.value == b"generic"
    assert "CNNSIM_POCL_PROCESSOR=auto" in pocl.remark(device)
    monkeypatch.setenv(pocl.VARIABLE, "a-long-name")
    with pytest.raises(InputError, match="'auto' or a name of at most 7 letters"):
        pocl.name_processor(device)
    monkeypatch.setenv(pocl.VARIABLE, "auto")
    assert not pocl.remark(device)
    pocl.name_processor(device)
    assert name.value in (b"skx", b"haswell", b"x86-64")
    monkeypatch.setenv(pocl.VARIABLE, "znver3")
    pocl.name_processor(device)
    assert name.value in (b"skx", b"haswell", b"x86-64")


def test_pocl_keeps_its_kernels_where_only_this_user_writes(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    monkeypatch.setenv(kernel_cache.VARIABLE, "mine")
    kernel_cache.prepare_cache.__wrapped__()
    assert os.environ[kernel_cache.VARIABLE] == "mine"
    monkeypatch.delenv(kernel_cache.VARIABLE)
    kernel_cache.prepare_cache.__wrapped__()
    assert Path(os.environ[kernel_cache.VARIABLE]).is_relative_to(tmp_path)


def test_the_cache_is_emptied_after_a_process_that_ended_at_a_first_use(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    monkeypatch.setenv(kernel_cache.VARIABLE, str(tmp_path))
    entry = tmp_path / "KA" / "program.bc"
    entry.parent.mkdir()
    entry.write_bytes(b"damaged")
    (tmp_path / "other.txt").touch()
    device = opencl_devices.choose_device()
    with kernel_cache.first_use(device):  # a process that still runs
        kernel_cache.prepare_cache.__wrapped__()
    kernel_cache.prepare_cache.__wrapped__()
    assert entry.exists()
    built = cl.Program(cl.Context([device]), "kernel void one() {}").build(options=["-w"])
    with pytest.raises(InputError, match="is damaged"), kernel_cache.first_use(device):
        cl.Kernel(built, "two")
    kernel_cache.prepare_cache.__wrapped__()
    assert [path.name for path in tmp_path.iterdir()] == ["other.txt"]


def test_what_pocl_needs_is_said_where_nothing_builds(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(pocl, "remark", lambda device: "set IT=auto")
    backend = OpenCLBackend()
    broken = Cellwise("broken", "", ("p",), ("q",), (), lambda p: (p,), opencl="q = nothing_of_this_name;")
    with pytest.raises(InputError, match=r": set IT=auto$"):
        backend.cellwise(broken, [backend.load(np.zeros((1, 1)), "lam")], ())
    assert "set IT=auto" in CliRunner().invoke(devices).output


def test_a_text_that_does_not_build_is_reported_with_driver_kernel_and_line() -> None:
    backend = OpenCLBackend()
    broken = Cellwise("broken", "", ("p",), ("q",), (), lambda p: (p,), opencl="q = nothing_of_this_name;")
    driver = backend.device.driver_version
    with pytest.raises(
        InputError, match=rf"driver .*{re.escape(driver)}: .*'cellwise'.* at 'q = nothing_of_this_name;'"
    ):
        backend.cellwise(broken, [backend.load(np.zeros((1, 1)), "lam")], ())


def test_a_device_without_enough_memory_is_reported_with_both_sizes() -> None:
    with pytest.raises(InputError, match=r"1.13e\+03 TB wanted for a plane; the device has .* a smaller grid"):
        OpenCLBackend()._context.buffer(1 << 50)


def test_a_home_that_cannot_be_written_stops_nothing() -> None:
    code = "import cnnsim, numpy; print(cnnsim.run('edge', numpy.ones((2, 3)), backend='opencl').y.shape)"
    nowhere = {**os.environ, "HOME": "/proc/none"}
    for variable in ("XDG_CACHE_HOME", kernel_cache.VARIABLE, "PYOPENCL_NO_CACHE"):
        nowhere.pop(variable, None)
    done = subprocess.run([sys.executable, "-c", code], env=nowhere, capture_output=True, text=True, check=False)
    assert done.stdout == "(2, 3)\n", done.stderr
    assert "Traceback" not in done.stderr


@pytest.mark.parametrize("kind", ["gpu", "cpu"])
def test_explain_leaves_sleep_out_on_a_gpu(kind: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(opencl_devices, "family_of", lambda device: kind)
    lines = dict(explain_template("hole-filler", (64, 64), "opencl").lines)
    assert ("no sleep" in lines) == (kind == "gpu")
    assert ("sleep" in lines) == (kind == "cpu")
