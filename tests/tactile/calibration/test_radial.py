"""Radial correction of located loads: closed forms, and refused scans."""

import numpy as np
import pytest

from cnnsim.support import Floats, InputError
from tactile.calibration.gains import Gains
from tactile.calibration.radial import RadialCorrection, radial_from_scan
from tactile.core.frame import Frame, TaxelArray
from tactile.elastic.halfspace import point_load_strain, point_load_stress
from tactile.finger import Finger
from tactile.inverse.taxel import invert_strain
from tactile.inverse.validity import Validity
from tactile.settings import Settings

DEPTH, MODULUS, FORCE = 2e-4, 2.4e6, 0.02


def loads(places: Floats) -> Floats:
    rows = np.zeros((len(places), 1, 5))
    rows[:, 0, :2], rows[:, 0, 4] = places, FORCE
    return rows


def strain(places: Floats) -> Floats:
    return point_load_strain((0.0, 0.0), DEPTH, loads(places), MODULUS)


def located(readings: Floats, depth: float = DEPTH) -> tuple[Floats, Floats]:
    """Return places (n, 2) and forces (n,)."""
    x, y, z = readings.T
    dx, dy, force, _ = invert_strain(x, y, z, depth, MODULUS, 0.0, 1)
    return np.array([dx, dy]).T, np.asarray(force)


def disc(n: int, reach: float) -> Floats:
    """Return n places spread evenly over a disc (sunflower)."""
    k = np.arange(1, n + 1)
    rho, turn = reach * np.sqrt(k / n), k * np.pi * (3 - np.sqrt(5))
    return np.stack([rho * np.cos(turn), rho * np.sin(turn)], axis=-1)


def bent(places: Floats) -> tuple[Floats, Floats]:
    """Return the places and forces by a strain inverse of a taxel that measures stress."""
    return located(Gains(1.5, 1.0)(point_load_stress((0.0, 0.0), DEPTH, loads(places)) / MODULUS))


def true_of(found: Floats) -> tuple[Floats, Floats]:
    """Return the true radius and force factor of a located radius [depths] for measured stress, in closed form."""
    true = 2 * found / (2 - found**2)
    return true, (2 - found**2) / 2 * ((1 + true**2) / (1 + found**2)) ** 2.5


def test_a_radial_correction_tends_to_the_closed_form() -> None:
    places = disc(20_000, 2.5e-4)
    seen, forces = bent(places)
    errors = []
    for rings in (5, 10, 20):
        correction = radial_from_scan(seen, places, forces, FORCE, rings)
        at = np.linspace(0.02, correction.found[-1] / DEPTH * 0.999, 200)
        dx, dy, force, validity = correction((0.6 * at * DEPTH, -0.8 * at * DEPTH, np.ones(200), np.ones(200)))
        radius, factor = true_of(at)
        assert (validity == Validity.INSIDE).all()
        assert dx * -0.8 == pytest.approx(dy * 0.6, abs=1e-18)  # along the same ray
        errors.append((np.abs(np.hypot(dx, dy) / DEPTH - radius).max(), np.abs(force / factor - 1).max()))
    coarse, middle, fine = np.array(errors)
    assert (fine < (2e-3, 5e-3)).all()
    assert (fine < middle / 2).all()
    assert (middle < coarse / 2).all()


def test_an_exact_map_is_unchanged() -> None:
    places = disc(500, 2e-4)
    seen, forces = located(strain(places))
    correction = radial_from_scan(seen, places, forces, FORCE, 8)
    use = np.hypot(*places.T) < 1.8e-4
    dx, dy, force, _ = correction((seen[use, 0], seen[use, 1], forces[use], np.ones(use.sum())))
    assert np.stack([dx, dy], axis=-1) == pytest.approx(places[use], rel=1e-12, abs=1e-18)
    assert force == pytest.approx(np.full(use.sum(), FORCE), rel=1e-12)


def test_answers_beyond_the_measured_radius_are_invalid() -> None:
    correction = RadialCorrection((0, 1, 2), (0, 2, 3), (1.0, 1.5, 2.0))
    at = np.array([0.0, 1.0, 2.0, 2.1, 0.0, 0.5])
    given = np.array([Validity.INSIDE, Validity.INSIDE, Validity.OUTSIDE, 1, Validity.NO_LOAD, Validity.INVALID], float)
    dx, dy, force, validity = correction((at, 0 * at, np.ones(6), given))
    assert dx.tolist() == pytest.approx([0, 2, 3, 0, 0, 0])
    assert not dy.any()
    assert force.tolist() == pytest.approx([1, 1.5, 2, 0, 0, 0])
    assert validity.tolist() == [1, 1, 2, Validity.INVALID, Validity.NO_LOAD, Validity.INVALID]


def test_noise_of_the_scan_averages_out() -> None:
    random = np.random.default_rng(3)
    places = disc(3000, 2.5e-4)
    seen, forces = bent(places)
    noisy = seen + random.normal(0, 3e-6, seen.shape)
    correction = radial_from_scan(noisy, places, forces * random.normal(1, 0.05, 3000), FORCE, 10)
    use = np.hypot(*places.T) < 2.2e-4
    dx, dy, force, _ = correction((seen[use, 0], seen[use, 1], forces[use], np.ones(use.sum())))
    before = np.sqrt(((seen[use] - places[use]) ** 2).sum(-1).mean())
    after = np.sqrt(((np.stack([dx, dy], -1) - places[use]) ** 2).sum(-1).mean())
    assert before > 30e-6
    assert after < 1e-6
    assert np.abs(force / FORCE - 1).max() < 0.02


PLACES = disc(300, 2e-4)
SEEN, FORCES = located(strain(PLACES))
BESIDE = PLACES + np.array([5e-4, 0])
NOISE, PRESSED = located(np.random.default_rng(2).normal(0, 1e-3, (300, 3)))
FOLDED = PLACES * (1 - (np.hypot(*PLACES.T) / 2.5e-4) ** 2)[:, None]


@pytest.mark.parametrize(
    ("seen", "places", "forces", "rings", "match"),
    [
        (SEEN[:10], PLACES[:10], FORCES[:10], 8, "at least 3 in every ring"),
        (*(located(strain(BESIDE))[0], BESIDE, FORCES), 8, "0 answers from 0 to .* um from the taxel"),
        (NOISE, PLACES, PRESSED, 8, "grows beyond its noise"),
        (FOLDED, PLACES, FORCES, 8, "located .* um from the taxel after .* um, where the needle was"),
        (SEEN, PLACES, -FORCES, 8, "one that presses"),
        (SEEN, PLACES, FORCES, 0, "0 rings"),
        (SEEN[1:], PLACES, FORCES, 8, r"\(299, 2\)"),
        (np.where(SEEN > 1e-4, np.inf, SEEN), PLACES, FORCES, 8, "not finite"),
        (np.zeros((9, 2)), np.zeros((9, 2)), np.ones(9), 1, "answers from 0"),
    ],
)
def test_scans_that_cannot_correct_are_refused(
    seen: Floats, places: Floats, forces: Floats, rings: int, match: str
) -> None:
    with pytest.raises(InputError, match=match):
        radial_from_scan(seen, places, forces, FORCE, rings)


@pytest.mark.parametrize(
    ("found", "true", "force", "match"),
    [
        ((0, 2, 1), (0, 1, 2), (1, 1, 1), "growing ones from 0"),
        ((0, 1), (0, 1), (1,), "equally many"),
        *(((0, 1), (0, 1), (1, factor), "positive ones wanted") for factor in (0.0, -1.0, np.nan, np.inf)),
    ],
)
def test_wrong_corrections_are_refused(
    found: tuple[float, ...], true: tuple[float, ...], force: tuple[float, ...], match: str
) -> None:
    with pytest.raises(InputError, match=match):
        RadialCorrection(found, true, force)


def test_one_taxel_does_not_locate_a_far_load_as_a_near_pull() -> None:
    """A pressing load beyond the scan, at 2.2 depths, has the readings of a pull at 0.9 depths."""
    depth, measured = 4e-4, RadialCorrection((0.0, 4.7e-4), (0.0, 4.7e-4), (1.0, 1.0))
    array = TaxelArray("one", 1, 1, 1e-3, depth)
    finger = Finger(array, 2.4e6, Settings(radial=measured))
    for x, force, wanted in ((-8.8e-4, 0.05, Validity.INVALID), (-2e-4, 0.02, Validity.INSIDE)):
        values = point_load_strain(array.positions(), depth, [(x, 0.0, 0.0, 0.0, force)], 2.4e6)
        load = finger.locate(Frame(0, 0.0, 0, values, np.ones((1, 1), bool)))
        assert load.validity is wanted
    assert (load.x, load.F) == pytest.approx((-2e-4, 0.02))
