"""Per-cell operations whose OpenCL text is missing or wrong."""

from dataclasses import replace

import numpy as np
import pytest

from cnnsim import InputError
from cnnsim.operations import cellwise
from tests.kits.opencl import OpenCLBackend


def test_an_operation_without_text_and_one_with_wrong_text() -> None:
    from cnnsim.backends.opencl.device.build import BuildError

    backend = OpenCLBackend()
    plane = backend.load(np.ones((2, 2)), "lam")
    add = cellwise.BUILT_IN["add"]
    with pytest.raises(InputError, match="'add' has no OpenCL text"):
        backend.cellwise(replace(add, opencl=""), [plane, plane], ())
    with pytest.raises(BuildError, match="undeclared identifier 'nothing'"):
        backend.cellwise(replace(add, opencl="sum = nothing;"), [plane, plane], ())
