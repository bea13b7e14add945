"""The verb for per-cell operations: the built-in ones, and the taxel inverses of the tactile layer."""

import numpy as np
import pytest

from cnnsim.backends.base import Backend
from cnnsim.operations import cellwise
from tactile.inverse.taxel import STRAIN_INVERSE, STRESS_INVERSE


@pytest.mark.parametrize("name", cellwise.BUILT_IN)
def test_built_in_operations(backend: Backend, name: str) -> None:
    operation = cellwise.BUILT_IN[name]
    inputs = np.random.default_rng(6).normal(size=(len(operation.inputs), 7, 30)).astype(backend.dtype)
    inputs[0, 3, 5] = np.nan
    parameters = (0.3, -2.0)[: len(operation.parameters)]
    got = backend.cellwise(operation, [backend.load(values, "lam") for values in inputs], parameters)
    rtol, atol = (1e-15, 0.0) if backend.dtype == "float64" else (1e-6, 1e-7)
    for ours, law in zip(got, operation.array(*inputs, *parameters), strict=True):
        assert np.allclose(backend.read(ours), law, rtol=rtol, atol=atol, equal_nan=True)


@pytest.mark.parametrize("quantity", ["strain", "stress"])
def test_taxel_inverses(backend: Backend, quantity: str) -> None:
    rng = np.random.default_rng(7)
    signals = (rng.normal(size=(3, 40, 50)) * 10.0 ** rng.uniform(-7, -2, (40, 50))).astype(backend.dtype)
    signals[:, 0, :5] = 0
    signals[0, 1, :3], signals[1, 2, :3], signals[:2, 3], signals[2, 4] = np.nan, np.inf, 0, 0
    operation = {"strain": STRAIN_INVERSE, "stress": STRESS_INVERSE}[quantity]
    tolerance = 1e-14 if backend.dtype == "float64" else 2e-6
    for parameters in [(2e-3, 1e6, 1e-6, p) for p in (-1, 0, 1)] if quantity == "strain" else [(2e-3, 1e-6)]:
        got = backend.cellwise(operation, [backend.load(s, "lam") for s in signals], parameters)
        law = operation.array(*signals, *parameters)
        assert np.array_equal(backend.read(got[3]), law[3])
        for ours, want in zip(got[:3], law[:3], strict=True):
            assert np.allclose(backend.read(ours), want, rtol=tolerance, atol=0)
