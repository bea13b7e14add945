"""The library's templates that are not linear, on the family of kernels that the device has not by itself."""

import pytest

from cnnsim import Template, library
from cnnsim.backends.opencl.device.devices import choose_device, family_of
from cnnsim.library.catalogue import run_example
from cnnsim.network import Cell
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
