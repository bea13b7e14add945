"""Backends by name, and what is said where there is none."""

import numpy as np
import pytest

from cnnsim import InputError, run
from cnnsim.backends import get
from cnnsim.backends.base import Backend
from tests.kits.backends import variants


@pytest.mark.parametrize("variant", variants("reference", "cpu"), ids=str)
def test_a_backend_has_its_name_and_dtype(variant: tuple[str, None, str]) -> None:
    name, _, dtype = variant
    backend: Backend = get(name, dtype)
    assert (backend.name, backend.dtype) == (name, np.dtype(dtype))


def test_the_reference_is_float64_only() -> None:
    with pytest.raises(InputError, match="float64, not in float32"):
        run("edge", np.ones((2, 2)), backend="reference", dtype="float32")


@pytest.mark.parametrize(("name", "meant"), [("gpu", "opencl"), ("opencll", "opencl"), ("CPU", "cpu")])
def test_an_unknown_backend_lists_the_known_ones_and_the_nearest(name: str, meant: str) -> None:
    with pytest.raises(InputError, match=f"known are reference, cpu, opencl; did you mean '{meant}'"):
        run("edge", np.ones((2, 2)), backend=name)
    with pytest.raises(InputError, match=r"known are reference, cpu, opencl$"):
        run("edge", np.ones((2, 2)), backend="abacus")
