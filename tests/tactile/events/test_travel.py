"""Travel of a located load: begins where the load leaves its place; times that jump back do not break it."""

import numpy as np
import pytest

from tactile.events.travel import Travel
from tactile.inverse.load import Load
from tactile.inverse.validity import Validity


def at(x: float) -> Load:
    return Load(x, 0.0, 0.0, 0.0, 1.0, taxels=4, validity=Validity.INSIDE)


@pytest.mark.parametrize("t", [np.arange(200) / 100, -np.arange(200) / 100], ids=["forth", "back"])
def test_it_travels_when_it_leaves_its_place(t: np.ndarray) -> None:
    rng, travel = np.random.default_rng(0), Travel()
    places = rng.normal(0, 2e-6, 200) + np.where(np.arange(200) < 150, 0.0, 1e-3)
    found = [travel.update(float(t[n]), at(float(x)), contact=True) for n, x in enumerate(places)]
    assert not any(found[:150])
    assert any(found[150:])
