"""Changes that readings and forces at their largest do not show: of noise above the signal, of what pulls, of maps."""

from dataclasses import replace

import numpy as np
import pytest

from tactile.core.frame import TaxelArray
from tactile.simulator.choice.auto_effects import choose
from tactile.simulator.contacts.height_map import HeightMap
from tactile.simulator.contacts.indenter import Indenter
from tactile.simulator.contacts.moving_contact import MovingContact
from tactile.simulator.contacts.moving_load import MovingLoad
from tactile.simulator.contacts.traction_map import TractionMap
from tactile.simulator.effects import make_effect
from tests.kits.touch.random_scenes import error_of_seeds, everything, needle


@pytest.mark.parametrize("reused", (True, False))
def test_noise_above_the_readings_is_what_a_low_pass_changes(reused: bool) -> None:
    scene = needle(
        ("read_noise", make_effect("read_noise", rms=2e-3)), ("low_pass", make_effect("low_pass", time=2e-6))
    )
    path = scene.loads[0].path * ([1] * 3 + [1e-4] * 3)
    scene = replace(scene, loads=(MovingLoad(0, path),))
    whole = everything(scene)
    passed = scene.with_effects([one for one in whole.effects if one[0] != "low_pass"])
    assert error_of_seeds(passed, whole, range(3)) > 0.02
    choice = choose(scene, 0.02, reused)
    assert error_of_seeds(choice.scene, whole, range(3)) <= choice.bound <= 0.02


@pytest.mark.parametrize("deep", ((43e-6, -4e-6), (30e-6, -3e-6)))
def test_what_pulls_beside_what_a_layer_stiffens_is_tried(deep: tuple[float, float]) -> None:
    flat = [(0.0, 0, 0, 0, 0, deep[0]), (1.0, 0, 0, 0, 0, deep[1])]
    scene = needle(
        ("finite_thickness", make_effect("finite_thickness", thickness=3e-3)),
        ("adhesion", make_effect("adhesion", work=0.0026)),
    )
    punch = MovingContact(0, Indenter("flat_punch", 1e-3), flat, given_depth=True)
    pad = TaxelArray("pad", 4, 4, 1e-3, 5e-4)
    scene = replace(scene, loads=(), contacts=(punch,), arrays=(pad,), rate=300.0)
    whole = everything(scene)
    dry = scene.with_effects([one for one in whole.effects if one[0] != "adhesion"])
    assert error_of_seeds(dry, whole, (0,)) > 0.05
    assert error_of_seeds(choose(scene, 0.008, reused=True).scene, whole, (0,)) <= 0.008


def test_a_traction_map_tells_no_hardest_moment() -> None:
    steps = (np.arange(9) - 4) * 1e-4
    ball = HeightMap(0, (steps**2 + steps[:, None] ** 2) / 1e-3, 1e-4, np.array([(0.0, 0, 0, 0, 0, 0.01)]))
    cells = TractionMap(0, np.array([(0, 0, 0, 0, 1e-3)]), np.array([(0.0, 0.0), (1.0, 1.0)]))
    scene = replace(needle().with_effects(()), loads=(), contacts=(cells, ball))
    choice = choose(scene, 0.05, reused=True)
    assert error_of_seeds(choice.scene, everything(scene), (0,)) <= choice.bound <= 0.05
