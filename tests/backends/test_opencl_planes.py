"""Planes on an OpenCL device: logic, neighbours, per-cell operations, both families of kernels."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from cnnsim import PERIODIC, ZERO_FLUX, InputError, fixed
from cnnsim.backends.reference.backend import ReferenceBackend
from cnnsim.operations import cellwise
from cnnsim.operations.bitwise import BitLiteral, BitRule
from cnnsim.operations.logic import FUNCTIONS
from tactile.inverse.taxel import STRAIN_INVERSE, STRESS_INVERSE

cl = pytest.importorskip("pyopencl", reason="the opencl backend needs pyopencl")

from cnnsim.backends.opencl import device as opencl_device  # noqa: E402 - only where pyopencl is there
from cnnsim.backends.opencl.backend import OpenCLBackend  # noqa: E402
from cnnsim.backends.opencl.build import BuildError  # noqa: E402

if not opencl_device.devices():
    pytest.skip("there is no OpenCL device", allow_module_level=True)

FAMILIES: Any = ["cpu", "gpu"]


@pytest.mark.parametrize("family", FAMILIES)
@pytest.mark.parametrize("shape", [(1, 1), (3, 63), (5, 64), (2, 3, 65), (300, 130)])
def test_logic_counting_and_conversion(shape: tuple[int, ...], family: Any) -> None:
    ours, law = OpenCLBackend(family=family), ReferenceBackend()
    p, q = np.random.default_rng(5).random((2, *shape)) < 0.5
    for function in range(len(FUNCTIONS)):
        plane = ours.logic(function, ours.load(p, "llm"), ours.load(q, "llm"))
        want = law.logic(function, p, q)
        assert np.array_equal(ours.read(plane), want)
        assert np.array_equal(ours.count(plane), law.count(want))
    lam = ours.convert(ours.load(p, "llm"), "lam")
    assert np.array_equal(ours.read(lam), np.where(p, 1, -1))
    assert np.array_equal(ours.read(ours.convert(lam, "llm")), p)


@pytest.mark.parametrize("family", FAMILIES)
@pytest.mark.parametrize("boundary", [ZERO_FLUX, PERIODIC, fixed(1.0), fixed(-1.0)], ids=str)
def test_neighbours_on_bits(boundary: Any, family: Any) -> None:
    rng = np.random.default_rng(10)
    ours, law = OpenCLBackend(family=family), ReferenceBackend()
    for shape in ((1, 1), (2, 3), (7, 64), (2, 9, 131), (4, 67), (2, 13, 704), (12, 771), (13, 1276)):
        for size, every in ((0, True), (1, False), (4, True), (9, False)):
            places = {(int(k), int(l)) for k, l in rng.integers(-5, 6, (size, 2))}
            rule = BitRule(tuple(BitLiteral(k, l, bool(rng.random() < 0.5)) for k, l in places), every)
            p = rng.random(shape) < (0.9 if every else 0.1)
            assert np.array_equal(
                ours.read(ours.neighbourhood(rule, boundary, ours.load(p, "llm"))), law.neighbourhood(rule, boundary, p)
            )


@pytest.mark.parametrize("family", FAMILIES)
def test_output_keeps_nan(family: Any) -> None:
    backend = OpenCLBackend(family=family)
    y = backend.read(backend.output(backend.load(np.array([[-3, -0.5, 2, np.nan]]), "lam")))
    assert np.array_equal(y, np.array([[-1, -0.5, 1, np.nan]], np.float32), equal_nan=True)


@pytest.mark.parametrize("family", FAMILIES)
@pytest.mark.parametrize("name", cellwise.BUILT_IN)
def test_cellwise(name: str, family: Any) -> None:
    operation = cellwise.BUILT_IN[name]
    backend = OpenCLBackend("float64", family=family)
    inputs = list(np.random.default_rng(6).normal(size=(len(operation.inputs), 7, 30)))
    inputs[0][3, 5] = np.nan
    parameters = (0.3, -2.0)[: len(operation.parameters)]
    got = backend.cellwise(operation, [backend.load(values, "lam") for values in inputs], parameters)
    for ours, law in zip(got, operation.array(*inputs, *parameters), strict=True):
        assert np.allclose(backend.read(ours), law, rtol=1e-15, atol=0, equal_nan=True)


@pytest.mark.parametrize("family", FAMILIES)
@pytest.mark.parametrize(("dtype", "tolerance"), [("float64", 1e-14), ("float32", 2e-6)])
@pytest.mark.parametrize("quantity", ["strain", "stress"])
def test_taxel_inverses(quantity: str, dtype: Any, tolerance: float, family: Any) -> None:
    rng = np.random.default_rng(7)
    signals = (rng.normal(size=(3, 40, 50)) * 10.0 ** rng.uniform(-7, -2, (40, 50))).astype(dtype)
    signals[:, 0, :5] = 0
    signals[0, 1, :3], signals[1, 2, :3], signals[:2, 3], signals[2, 4] = np.nan, np.inf, 0, 0
    operation = {"strain": STRAIN_INVERSE, "stress": STRESS_INVERSE}[quantity]
    backend = OpenCLBackend(dtype, family=family)
    for parameters in [(2e-3, 1e6, 1e-6, p) for p in (-1, 0, 1)] if quantity == "strain" else [(2e-3, 1e-6)]:
        got = backend.cellwise(operation, [backend.load(s, "lam") for s in signals], parameters)
        law = operation.array(*signals, *parameters)
        assert np.array_equal(backend.read(got[3]), law[3])
        for ours, want in zip(got[:3], law[:3], strict=True):
            assert np.allclose(backend.read(ours), want, rtol=tolerance, atol=0)


def test_an_operation_without_text_and_one_with_wrong_text() -> None:
    backend = OpenCLBackend()
    plane = backend.load(np.ones((2, 2)), "lam")
    add = cellwise.BUILT_IN["add"]
    with pytest.raises(InputError, match="'add' has no OpenCL text"):
        backend.cellwise(replace(add, opencl=""), [plane, plane], ())
    with pytest.raises(BuildError, match="undeclared identifier 'nothing'"):
        backend.cellwise(replace(add, opencl="sum = nothing;"), [plane, plane], ())
