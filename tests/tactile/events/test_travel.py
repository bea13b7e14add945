"""Travel of a located load: detected when it leaves its place."""

from dataclasses import replace

import numpy as np
import pytest

from tactile.events.load_travel import Travel
from tactile.inverse.load import Load
from tactile.inverse.validity import Validity
from tactile.simulator.scene_file.file import scene_from
from tests.kits.touch.made import events


def at(x: float) -> Load:
    return Load(x, 0.0, 0.0, 0.0, 1.0, taxels=4, validity=Validity.INSIDE)


@pytest.mark.parametrize("t", [np.arange(200) / 100, -np.arange(200) / 100], ids=["forth", "back"])
def test_a_load_that_leaves_its_place_travels(t: np.ndarray) -> None:
    rng, travel = np.random.default_rng(0), Travel()
    places = rng.normal(0, 2e-6, 200) + np.where(np.arange(200) < 150, 0.0, 1e-3)
    found = [travel.update(float(t[n]), at(float(x)), contact=True) for n, x in enumerate(places)]
    assert not any(found[:150])
    assert any(found[150:])


def test_a_change_to_another_load_is_no_travel() -> None:
    """Two loads 6 mm apart: the second becomes the stronger one and ends; later it replaces the first."""
    travel, found = Travel(), []
    for n in range(300):
        first, second = at(0.0), replace(at(6e-3), F=2.0 if 100 <= n < 200 else 0.5)
        both = sorted((first, second) if 50 <= n < 250 else (first,), key=lambda one: -one.F)
        seen = replace(both[0], others=tuple(both[1:])) if n < 280 else second
        found.append(travel.update(n / 100, seen, contact=True))
    assert not any(found)
    assert travel.update(3.0, at(6.2e-3), contact=True)  # tracked from its new place


def test_an_uncertain_place_does_not_travel() -> None:
    """At the start of a contact, noise moves the place by 0.1 mm; then it is constant."""
    uncertain, certain = (3e-5, 3e-5, 0.0, 0.0, 0.0), (1e-6, 1e-6, 0.0, 0.0, 0.0)
    found, travel = [], Travel()
    for n, (x, sigma) in enumerate(
        [(0.0, uncertain), (6e-5, uncertain), *[(1e-4, certain)] * 30, *[(3e-4, certain)] * 9]
    ):
        found.append(travel.update(n / 250, replace(at(x), scatter=sigma), contact=True))
    assert not any(found[:32])
    assert found[32]


@pytest.mark.parametrize(("shear", "direction"), [(0.0, "-x"), (0.2, "+x")])
def test_a_slip_has_the_direction_of_the_tangential_load_or_else_of_its_travel(shear: float, direction: str) -> None:
    path = [[t, x, 0, q, 0, f] for t, x, q, f in (
        (0.2, 1.5, 0, 0), (0.4, 1.5, shear, 0.5), (0.7, 1.5, shear, 0.5), (1.2, -1.5, shear, 0.5),
        (1.9, -1.5, shear, 0.5),
    )]  # fmt: skip
    table = {
        "title": "t", "rate_hz": 100, "duration_s": 1.9, "cover": {"youngs_modulus_mpa": 2.4, "quantity": "strain"},
        "finger": [{"name": "pad", "rows": 4, "cols": 4, "pitch_mm": 1.5, "depth_mm": 1.5}],
        "load": [{"finger": "pad", "path": path}], "effect": {"read_noise": {"rms": 0.0005}},
    }  # fmt: skip
    (slip,) = (event for event in events(scene_from(table, "here")) if event.kind == "slip")
    assert slip.data["direction"] == direction
    assert slip.words.startswith(f"slip {direction}")
