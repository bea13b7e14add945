"""The range of a scene's models is judged in the frames that strain its taxels most: against all of them."""

import re
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

from cnnsim.support import InputError
from tactile.core.frame import TaxelArray
from tactile.simulator.contacts.height_map import HeightMap
from tactile.simulator.contacts.indenter import Indenter
from tactile.simulator.contacts.materials import PRESETS
from tactile.simulator.contacts.moving_contact import MovingContact
from tactile.simulator.contacts.moving_load import MovingLoad
from tactile.simulator.contacts.sliding_texture import SlidingTexture
from tactile.simulator.contacts.traction_map import TractionMap
from tactile.simulator.effects import make_effect
from tactile.simulator.scene.hardest_frames import most_strained
from tactile.simulator.scene.scene import Scene

CHIP = TaxelArray("chip", 2, 2, 4e-4, 2e-4)
PAD = TaxelArray("pad", 3, 8, 1e-3, 5e-4)


def strained(scene: Scene) -> float:
    """The largest reading of all frames, without electronics: a strain."""
    fields = scene.affected(scene.skin.fields(0, scene.skin.chunks(0)), "field", scene.effects, 0)
    return max(float(np.abs(field.values).max()) for field in fields)


def told(scene: Scene) -> float:
    """The strain that the scene tells, 0 for none."""
    try:
        lines = " ".join(scene.range_notes)
    except InputError as error:
        lines = str(error)
    found = re.search(r"strains to ([\d.e+-]+);", lines)
    return float(found[1]) if found else 0.0


def of(
    *pressing: Any, effects: Any = (), array: TaxelArray = CHIP, rate: float = 1000.0, duration: float = 10.0,
    modulus: float = 2.4e6,
) -> Scene:  # fmt: skip
    loads = [one for one in pressing if isinstance(one, MovingLoad)]
    contacts = [one for one in pressing if not isinstance(one, MovingLoad)]
    return Scene("s", rate, duration, modulus, (array,), loads, contacts, effects, accuracy=1e-3)


@pytest.mark.parametrize("at", (1.234, 9.876))
def test_a_load_of_one_frame_is_seen(at: float) -> None:
    light, hard = (2e-4, 2e-4, 0, 0, 1e-3), (2e-4, 2e-4, 0, 0, 1.0)
    path = [(0.0, *light), (at - 1e-3, *light), (at, *hard), (at + 1e-3, *light), (10.0, *light)]
    with pytest.raises(InputError, match=r"strains to 4\.97; at most 1 wanted"):
        _ = of(MovingLoad(0, path)).range_notes
    unseen = [(t + 5e-4 * (1 < t < 10), *row) for t, *row in path]  # between two frames, half as hard in both
    assert told(of(MovingLoad(0, unseen))) == pytest.approx(4.97 / 2, rel=0.01)


def test_a_load_that_rushes_over_the_array_is_seen() -> None:
    path = [
        (0.0, -9e-3, 0, 0, 0, 0.5),
        (5.0, -9e-3, 0, 0, 0, 0.5),
        (5.02, 9e-3, 0, 0, 0, 0.5),
        (10, 9e-3, 0, 0, 0, 0.5),
    ]
    scene = of(MovingLoad(0, path), array=PAD)
    assert 0.3 < strained(scene) == pytest.approx(told(scene), rel=0.01)


@pytest.mark.parametrize("kind", ("load", "needle", "depth", "height_map", "texture", "map"))
@pytest.mark.parametrize("seed", range(2))
def test_the_strain_told_is_nearly_that_of_all_frames(kind: str, seed: int) -> None:
    random = np.random.default_rng(seed)
    t = np.concatenate([[0.0], np.sort(random.uniform(0, 2, 12)), [2.0]])
    path = np.zeros((14, 6))
    path[:, 0], path[:, 1:3] = t, random.uniform(-1, 1, (14, 2)) * (4e-3, 1.5e-3)
    path[:, 5] = 0.6 * np.exp(random.uniform(-4, 0, 14))
    path[:, 3:5] = random.uniform(-0.5, 0.5, (14, 2)) * path[:, 5:]
    effects = [make_effect("finite_thickness", thickness=1.5e-3)] if seed == 1 else []
    steps = (np.arange(25) - 12) * 2e-4
    cells = np.array([(x, y, 0, 0, 0.1) for x in (-2e-4, 2e-4) for y in (-2e-4, 2e-4)])
    made: dict[str, Callable[[], Any]] = {
        "load": lambda: MovingLoad(0, path),
        "needle": lambda: MovingContact(0, Indenter("needle", 4e-3), path, 0.5),
        "depth": lambda: MovingContact(0, Indenter("needle", 4e-3), path * ([1] * 5 + [5e-4]), None, True),
        "height_map": lambda: HeightMap(0, (steps**2 + steps[:, None] ** 2) / 4e-3, 2e-4, path),
        "texture": lambda: SlidingTexture(0, (5e-4, 0.0), PRESETS["rasp"], 0.3, 1.9, 5e-3, 0.3, 0.4, 1e3, seed),
        "map": lambda: TractionMap(0, cells, np.stack([t, random.uniform(-1, 3, 14)], axis=1)),
    }
    second = MovingLoad(0, path[::-1] * [-1, 1, 1, 0.3, 0.3, 0.3] + [2, 0, 0, 0, 0, 0])
    modulus = {"texture": 2.4e6, "load": 8e5, "map": 8e5}.get(kind, 5e5)
    scene = of(made[kind](), second, effects=effects, array=PAD, rate=200.0, duration=2.0, modulus=modulus)
    wanted = strained(scene)
    assert wanted > 0.3
    (every,) = scene.affected([scene.skin.field(0, np.arange(400) / 200.0)], "field", scene.effects, 0)
    assert wanted < most_strained(every) < 40 * wanted
    assert 0.9 * wanted < told(scene) < 1.01 * wanted  # the frames are chosen by how near the loads pass, no more


@pytest.mark.parametrize("effect", ("needle_vibration", "surface_waviness"))
@pytest.mark.parametrize("kind", ("load", "needle"))
def test_what_shakes_contacts_strains_as_it_does_in_the_run(effect: str, kind: str) -> None:
    path = [(0.0, -2e-4, -2e-4, 0, 0, 5e-3), (1.0, 2e-4, 2e-4, 0, 0, 5e-3)]
    body: Any = MovingLoad(0, path) if kind == "load" else MovingContact(0, Indenter("needle", 1e-4), path)
    told_once = False
    for size in (1e-6, 1e-5, 2e-5, 5e-5, 1.5e-4):
        given = {"vertical": size} if effect == "needle_vibration" else {"rms": size, "wavelength": 1e-4}
        scene = of(body, effects=[make_effect(effect, **given)], duration=1.0)
        most, found = strained(scene), told(scene)
        assert found == (pytest.approx(most, rel=0.01) if most > 0.3 else 0)
        told_once |= found > 0
    assert told_once


def test_a_body_that_is_shaken_too_deep_is_told() -> None:
    path = [(0.0, 0, 0, 0, 0, 2e-3), (1.0, 0, 0, 0, 0, 2e-3)]
    ball = MovingContact(0, Indenter("sphere", 1e-4), path)
    still = of(ball, array=PAD, duration=1.0)
    assert ["dead band" in note for note in still.range_notes] == [True]  # and nothing else
    shaken = still.with_effects([("needle_vibration", make_effect("needle_vibration", vertical=4e-5))])
    with pytest.raises(InputError, match=r"mm in radius of a sphere of radius 0\.1 mm; at most the sphere's own"):
        _ = shaken.range_notes
