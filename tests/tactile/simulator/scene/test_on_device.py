"""Scenes on OpenCL, in float32 and float64: the same frames as on the CPU."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from cnnsim.support import InputError
from tactile.core.frame import TaxelArray
from tactile.simulator.contacts.indenter import Indenter
from tactile.simulator.contacts.moving_contact import MovingContact
from tactile.simulator.contacts.moving_load import MovingLoad
from tactile.simulator.effects.finite_thickness import FiniteThickness
from tactile.simulator.effects.read_noise import ReadNoise
from tactile.simulator.effects.taxel_area import TaxelArea
from tactile.simulator.scene.scene import Scene
from tests.kits.backends import build

PATH = np.array(
    [(0.0, -1e-3, 0, 0, 0, 0.0, 0), (1.0, 0, 5e-4, 0.05, 0.01, 0.5, 1e-5), (2.0, 2e-3, 0, -0.02, 0, 0.2, 0)]
)
BALL = MovingContact(0, Indenter("sphere", 5e-3), PATH, 0.5)
SCENE = Scene("s", 50.0, 2.0, 2.4e6, (TaxelArray("pad", 4, 5, 1e-3, 1e-3),), (MovingLoad(0, PATH[:, :6]),), (BALL,))


@pytest.mark.parametrize(("dtype", "bound"), [("float64", 1e-12), ("float32", 2e-6)])
@pytest.mark.parametrize("effects", [(), (FiniteThickness(1.5e-3), TaxelArea(3e-4), ReadNoise())], ids=("bare", "more"))
def test_a_scene_on_a_device_is_that_on_the_cpu(dtype: Any, bound: float, effects: Any) -> None:
    build("opencl", None, dtype)  # skips where there is none
    scene = replace(SCENE, effects=effects)
    plain = np.stack([frame.values for frame in scene])
    on_device = np.stack([frame.values for frame in replace(scene, backend="opencl", dtype=dtype)])
    assert np.abs(plain - on_device).max() < bound * np.abs(plain).max()


def test_numbers_that_the_cpu_does_not_take_are_refused() -> None:
    with pytest.raises(InputError, match="cpu in float32; one of cpu in float64, opencl in float64, opencl in float32"):
        replace(SCENE, dtype="float32")
