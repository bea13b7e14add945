"""Contacts that slide first and stick later, on one straight way from keyframe to keyframe."""

import numpy as np
import pytest
from numpy.typing import NDArray

from tactile.elastic.medium import Medium
from tactile.elastic.profiles import HERTZ
from tactile.simulator.contacts.indenter import Indenter
from tactile.simulator.contacts.mounting import Rig
from tactile.simulator.contacts.moving_contact import MovingContact
from tactile.simulator.summation import field_at

MU, R, DEPTH = 0.5, 5e-3, 1e-3
RUBBER, LAYER = Medium(2.4e6), Medium(2.4e6, 0.45, thickness=3e-3)
AT = np.stack(np.meshgrid(np.linspace(-6e-3, 6e-3, 13), [0.0, 1e-3]), axis=-1).reshape(-1, 2)


def ball(rows: object, by_depth: bool = False) -> MovingContact:
    return MovingContact(0, Indenter("sphere", R), np.asarray(rows, np.float64), MU, by_depth)


def cut(contact: MovingContact, parts: int) -> MovingContact:
    """The same contact with keyframes between its keyframes."""
    path = contact.path
    t = np.unique(
        np.concatenate([np.linspace(a, b, parts + 1) for a, b in zip(path[:-1, 0], path[1:, 0], strict=True)])
    )
    rows = np.stack([np.interp(t, path[:, 0], column) for column in path.T], axis=1)
    return MovingContact(0, contact.indenter, rows, MU, contact.given_depth)


def felt(contact: MovingContact, times: NDArray[np.float64], medium: Medium, rig: Rig) -> NDArray[np.float64]:
    return field_at(AT, DEPTH, contact.loads(times, DEPTH, medium, rig), medium, accuracy=1e-5)


@pytest.mark.parametrize("start", ("touches", "lifted", "pulled"))
def test_a_body_that_is_dragged_before_it_is_pressed_on_slides_until_it_holds(start: str) -> None:
    # the pull Q is there all along: all slides up to P = Q / mu; from then on what is new under the load has no shear
    begin = {"touches": 0.0, "lifted": -0.5, "pulled": 0.2}[start]
    pull, push = 0.3, 2.0
    dragged = ball([(0.0, 0, 0, pull, 0, begin), (1.0, 0, 0, pull, 0, push)])
    state = dragged.friction_at(np.array([1.0]), RUBBER)[0]
    assert state.ends == pytest.approx([pull / MU, push])
    assert state.shares == pytest.approx(np.array([[1.0, 0.0], [0.0, 0.0]]), abs=1e-9)
    loads = dragged.loads(np.array([1.0]), DEPTH, RUBBER)
    (disc,) = loads.discs
    held = disc.radii[0][np.abs(disc.loads[0, :, 2]) > 1e-9 * pull]
    assert held == pytest.approx(np.cbrt(0.75 * pull / MU * R / RUBBER.contact_modulus))
    assert disc.profile is HERTZ


def test_a_pull_that_turns_back_while_it_slides() -> None:
    # it slides until Q(t) = mu P(t), carries that, and turns back by more than mu dP: from its rim inwards
    there = ball([(0.0, 0, 0, 0.5, 0, 0.5), (1.0, 0, 0, -0.4, 0, 2.0)])
    state = there.friction_at(np.array([1.0]), RUBBER)[0]
    assert state.ends == pytest.approx([(2.0 - 0.4 / MU) / 2, 2.0])
    assert state.shares[:, 0] == pytest.approx([1.0, -1.0])


@pytest.mark.parametrize("kind", ("force", "depth", "layer", "sticky"))
@pytest.mark.parametrize("seed", range(2))
def test_one_straight_way_is_as_many_small_steps(kind: str, seed: int) -> None:
    """Along one line, pulled and pressed by chance, lifted off now and then."""
    random = np.random.default_rng(seed)
    path = np.zeros((7, 6))
    path[:, 0] = np.arange(7)
    push = random.uniform(-0.5, 2.0, 7)
    path[:, 3] = MU * random.uniform(-1.5, 1.5, 7)
    by_depth = kind == "depth"
    path[:, 5] = push * 1e-4 if by_depth else push
    one = ball(path, by_depth)
    medium, rig = (LAYER if kind == "layer" else RUBBER), Rig(work=0.05 if kind == "sticky" else 0.0)
    times = np.linspace(0.05, 5.95, 40)
    coarse, fine = felt(one, times, medium, rig), felt(cut(one, 200), times, medium, rig)
    assert np.abs(fine).max() > 1e-3
    assert np.abs(coarse - fine).max() < 3e-3 * np.abs(fine).max()
