"""Templates of the library on the family of kernels that the device does not use; per-cell operations without text."""

from dataclasses import replace

import numpy as np
import pytest

from cnnsim import InputError, Template, library
from cnnsim.backends.opencl.device.build import BuildError
from cnnsim.backends.opencl.device.devices import choose_device, family_of
from cnnsim.library.catalogue import run_example
from cnnsim.network import Cell
from cnnsim.operations import cellwise
from tests.kits.opencl import FAMILIES, Family, OpenCLBackend

ENTRIES = [library.load(name) for name in library.names()]
KINDS = [e.name for e in ENTRIES if not (isinstance(e.network, Template) and e.template.linear) or e.cell != Cell()]


@pytest.mark.parametrize("family", [family for family in FAMILIES if family != family_of(choose_device())])
@pytest.mark.parametrize("name", KINDS)
def test_the_examples_of_a_template(name: str, family: Family) -> None:
    """The device's own family, and the other backends, run all examples in the tests of the library."""
    entry, where = library.load(name), OpenCLBackend("float32", family=family)
    for example in entry.examples:
        assert example.holds(run_example(entry, example, backend=where).y)


def test_an_operation_without_text_and_one_with_wrong_text() -> None:
    backend = OpenCLBackend()
    plane = backend.load(np.ones((2, 2)), "lam")
    add = cellwise.BUILT_IN["add"]
    with pytest.raises(InputError, match="'add' has no OpenCL text"):
        backend.cellwise(replace(add, opencl=""), [plane, plane], ())
    with pytest.raises(BuildError, match="undeclared identifier 'nothing'"):
        backend.cellwise(replace(add, opencl="sum = nothing;"), [plane, plane], ())
