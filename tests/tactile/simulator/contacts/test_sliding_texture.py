"""Textured objects that slide over the skin: the textures they declare, their sticking and slipping."""

import numpy as np
import pytest

from cnnsim.support import InputError
from tactile.elastic.medium import Medium
from tactile.simulator.contacts.materials import PRESETS, Material
from tactile.simulator.contacts.sliding_texture import SlidingTexture
from tactile.texture.figures import Texture

RUBBER = Medium(2.4e6)


def drawn(material: str, seed: int = 1, force: float = 0.1, duration: float = 2.5) -> SlidingTexture:
    return SlidingTexture(0, (0.0, 0.0), PRESETS[material], 0.0, duration, 5e-3, 0.5, force, 1e3, seed)


@pytest.mark.parametrize("name", PRESETS)
def test_profiles_have_the_statistics_they_declare(name: str) -> None:
    material = PRESETS[name]
    way = np.linspace(0, 2.0, 400_001)
    height = material.profile(way, np.random.default_rng(4))
    assert abs(height.mean()) < 0.01
    assert height.std() == pytest.approx(np.hypot(material.regular, material.irregular), rel=0.03)


@pytest.mark.parametrize("name", PRESETS)
def test_a_drawn_object_sticks_and_slips_within_its_friction(name: str) -> None:
    material, times = PRESETS[name], np.linspace(0, 2.5, 20_001)
    shear, normal = drawn(name).series(times)
    assert (shear <= material.static * normal + 1e-12).all()
    late = times > 0.2
    ratio = shear[late & (normal > 0.03)] / normal[late & (normal > 0.03)]
    assert 0.3 * material.kinetic < ratio.mean() < material.static
    drops = np.diff(shear) < -0.5 * (material.static - material.kinetic) * normal[1:]
    assert drops.sum() > 5  # slips
    assert normal[late].mean() == pytest.approx(0.1, rel=0.1)
    before, after = drawn(name).series(np.array([-0.1, 2.6]))
    assert not before.any()
    assert not after.any()
    loads = drawn(name).loads(times, 1e-3, RUBBER)
    assert np.arctan2(loads.totals[500, 0, 3], loads.totals[500, 0, 2]) == pytest.approx(0.5)


def test_the_four_materials_are_told_apart_by_friction_and_roughness() -> None:
    # the paper's figures of merit (19), (20): T = 128 frames of 15 ms, many profiles, different forces
    clouds = {}
    for name in PRESETS:
        points = []
        for seed in range(12):
            times = np.linspace(0.3, 0.3 + 127 * 0.015, 128)
            shear, normal = drawn(name, seed, 0.05 + 0.01 * seed).series(times)
            texture = Texture(128, 0.0)
            for s, f in zip(shear, normal, strict=True):
                figures = texture.update(np.array([[[s * np.cos(0.5), s * np.sin(0.5), -max(f, 1e-3)]]]))
            points.append((figures.friction[0, 0], figures.roughness[0, 0]))
        clouds[name] = np.array(points)
    names = list(PRESETS)
    for k, a in enumerate(names):
        for b in names[k + 1 :]:
            apart = np.abs(clouds[a].mean(0) - clouds[b].mean(0))
            spread = clouds[a].std(0) + clouds[b].std(0)
            assert (apart > spread).any(), (a, b, clouds[a].mean(0), clouds[b].mean(0), spread)


def test_drawing_without_stick_slip_slides_and_wrong_objects_are_refused() -> None:
    smooth = Material("ice", 1e-3, 0.0, 1e-3, 0.0, 0.0, 0.1, 0.1)
    shear, normal = SlidingTexture(0, (0, 0), smooth, 0.0, 2.0, 5e-3, 0.0, 0.1, 1e3).series(np.linspace(0.1, 2, 50))
    assert normal == pytest.approx(np.full(50, 0.1))
    assert shear == pytest.approx(np.full(50, 0.01), rel=0.02)
    still, _ = SlidingTexture(0, (0, 0), smooth, 0.0, 2.0, 0.0, 0.0, 0.1, 1e3).series(np.array([1.0]))
    assert still[0] == 0
    with pytest.raises(InputError, match="stop after start"):
        SlidingTexture(0, (0, 0), smooth, 2.0, 2.0, 5e-3, 0.0, 0.1, 1e3)
    with pytest.raises(InputError, match="steps to draw"):
        SlidingTexture(0, (0, 0), PRESETS["rasp"], 0.0, 1e6, 1.0, 0.0, 0.1, 1e3)
    with pytest.raises(InputError, match="kinetic <= static"):
        Material("m", 1e-3, 0.0, 1e-3, 0.0, 0.0, 0.1, 0.2)
    with pytest.raises(InputError, match="lengths"):
        Material("m", 0.0, 0.0, 1e-3, 0.0, 0.0, 0.1, 0.1)
