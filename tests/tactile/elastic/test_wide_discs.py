"""Circles of many depths by harmonics: against the quadrature along their line of sources."""

import numpy as np
import pytest

from tactile.elastic.discs import disc_load, twist_load
from tactile.elastic.layer_contact import layer_contact
from tactile.elastic.medium import Medium
from tactile.elastic.profiles import FLAT_PUNCH, HERTZ, ROUND_TIP, UNIFORM, Profile
from tactile.elastic.wide_discs import add_wide, harmonics

LAYER = layer_contact("paraboloid", 0.5).profile


def places(radius: float) -> np.ndarray:
    rng = np.random.default_rng(1)
    x = np.concatenate(
        [[0.0, 1e-5, 0.1], radius * rng.uniform(0, 2, 40), radius + rng.uniform(-3, 3, 40), [9 * radius]]
    )
    return np.stack([x, 0.1 * (np.arange(x.size) > 1)], axis=-1)


@pytest.mark.parametrize("radius", (0.5, 7.0, 30.0, 100.0))
@pytest.mark.parametrize(("profile", "lam"), [(HERTZ, 0.0), (FLAT_PUNCH, 0.0), (ROUND_TIP, 0.9), (LAYER, 6.0)])
def test_harmonics_are_the_field_of_the_circle(profile: Profile, lam: float, radius: float) -> None:
    at, size = places(radius), np.full((1, 1), radius)
    for accuracy in (1e-3, 1e-4, 1e-6):
        terms, enough = harmonics(profile, np.array([lam]), size[0], accuracy)
        closed = profile in (HERTZ, FLAT_PUNCH)
        if radius == 100.0 and accuracy < 1e-4 and not closed:  # the quadrature is no better there
            continue
        assert enough.all()
        for force in ((0, 0, 1.0), (1.0, -0.4, 0.0)):
            for medium in (Medium(2.0, 0.3), Medium(1.0, 0.5, "stress")):
                load, found = np.array([[[0.0, 0.0, *force]]]), np.zeros((1, len(at), 3))
                add_wide(found, at, 1.0, load, size, terms[None], medium)
                known = disc_load(at, 1.0, load[:, None], size[None], profile, medium, np.full((1, 1, 1), lam))
                assert np.abs(found - known).max() < (1e-11 if closed else accuracy) * np.abs(known).max()


def test_a_twist_and_several_circles_add_up_in_metres() -> None:
    depth, radii = 1e-3, np.array([[9e-3, 0.0, 2e-2]])
    rows = np.array([[[1e-3, 0.0, 0.1, 0.2, 1.0, 3e-3], [0, 0, 1.0, 1, 1, 1], [0.0, 2e-3, 0, 0, 0.5, -1e-3]]])
    at, medium = places(9.0) * depth, Medium(2.4e6)
    terms, _ = harmonics(HERTZ, np.zeros(3), radii[0] / depth, 1e-6)
    found = np.zeros((1, len(at), 3))
    add_wide(found, at, depth, rows, radii, terms[None], medium)
    known = sum(
        disc_load(at, depth, rows[:, None, [n], :5], radii[:, None, [n]], HERTZ, medium)
        + twist_load(at, depth, rows[:, None, [n]][..., [0, 1, 5]], radii[:, None, [n]], medium)
        for n in (0, 2)
    )
    assert np.abs(found - known).max() < 1e-11 * np.abs(known).max()


def test_where_the_terms_do_not_do_it_is_said() -> None:
    for profile, lam in ((UNIFORM, 0.0), (ROUND_TIP, 0.99999)):
        assert not harmonics(profile, np.array([lam]), np.array([30.0]), 1e-4)[1].any()
