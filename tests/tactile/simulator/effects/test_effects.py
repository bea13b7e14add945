"""Every effect: nothing at strength zero, the same however the frames are cut, said in words and tables."""

import contextlib
import dataclasses
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from cnnsim.support import InputError
from tactile.simulator.contacts.indenter import Indenter
from tactile.simulator.contacts.moving_contact import MovingContact
from tactile.simulator.effects import ORDER, effect_class, read_effect, without
from tactile.simulator.effects.dead_taxels import DeadTaxels
from tactile.simulator.effects.electronics.clipping import Clipping
from tactile.simulator.effects.finite_thickness import FiniteThickness
from tactile.simulator.effects.frame_timing import FrameTiming
from tactile.simulator.effects.quantisation import Quantisation
from tactile.simulator.effects.viscoelastic import Viscoelastic
from tests.kits.paths import ROOT
from tests.kits.touch.effects import ARRAY, scene, through


@pytest.mark.parametrize("name", ORDER)
def test_strength_zero_is_the_identity(name: str) -> None:
    plain, same = scene(), scene(effects=((name, without(effect_class(name))),))
    for one, other in zip(plain.batches(0), same.batches(0), strict=True):
        assert np.array_equal(one.values, other.values)
        assert np.array_equal(one.t, other.t)
        assert np.array_equal(one.sequence, other.sequence)
    assert same.frames == plain.frames


@pytest.mark.parametrize("name", ORDER)
@pytest.mark.parametrize("quantity", ("strain", "stress"))
@pytest.mark.filterwarnings("ignore::tactile.simulator.scene.scene.ModelRangeWarning")  # a ball is pulled off
def test_effects_do_something_and_do_not_care_how_frames_are_cut(
    name: str, quantity: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    effect: Any = effect_class(name)()
    if name == "dead_taxels":
        effect = DeadTaxels(0.3, 0.3)
    if name == "clipping":
        effect = Clipping(0.3)
    if name == "frame_timing":
        effect = FrameTiming(1e-3, 0.2, 0.2)
    touched = scene(effects=((name, effect),), arrays=(replace(ARRAY, quantity=quantity),))
    if name == "adhesion":  # points do not stick
        ball = MovingContact(0, Indenter("sphere", 1e-3), np.array([(0.0, 0, 0, 0, 0, 1e-3), (1.0, 0, 0, 0, 0, -1e-3)]))
        touched = replace(touched, loads=(), contacts=(ball,))
    whole = list(touched)
    monkeypatch.setattr("tactile.simulator.ideal_skin.CHUNK", 7)
    pieces = list(touched)
    assert [frame.t for frame in whole] == [frame.t for frame in pieces]
    assert [frame.sequence for frame in whole] == [frame.sequence for frame in pieces]
    ones, others = (np.stack([frame.values for frame in frames]) for frames in (whole, pieces))
    assert np.isfinite(ones).all()
    assert np.abs(ones - others).max() < 1e-12 * np.abs(ones).max()
    plain = np.stack([frame.values for frame in touched.with_effects(())])
    changed = ones.shape != plain.shape or not np.array_equal(ones, plain)
    assert changed != (name == "poisson_ratio" and quantity == "stress")  # stress does not depend on nu


@pytest.mark.parametrize("name", ORDER)
def test_every_effect_says_what_it_is(name: str) -> None:
    kind: Any = effect_class(name)
    assert kind.STAGE in ("field", "frames")
    assert set(kind.NONE) <= {field.name for field in dataclasses.fields(kind)}
    assert {attribute for attribute, _ in kind.KEYS.values()} == {field.name for field in dataclasses.fields(kind)}
    assert kind.__doc__
    # an effect that draws no numbers gives the same whatever the generator
    one, other = (list(scene(effects=((name, kind()),), seed=seed)) for seed in (0, 5))
    same = len(one) == len(other) and all(np.array_equal(a.values, b.values) for a, b in zip(one, other, strict=True))
    assert same or kind.RANDOM


def test_effects_read_their_tables() -> None:
    read: Any = read_effect
    assert read("finite_tip", {"radius_um": 20}, "here").radius == pytest.approx(20e-6)
    assert read("viscoelastic", {"parts": [[0.1, 2]], "creep": True}, "here") == Viscoelastic(((0.1, 2.0),), True)
    assert read("finite_thickness", {"thickness_mm": 0.5}, "here") == FiniteThickness(0.5e-3)
    assert read("quantisation", {"bits": 10}, "here") == Quantisation(10)
    wrong: tuple[tuple[str, dict[str, Any], str], ...] = (
        ("read_nose", {}, "unknown key 'read_nose'; did you mean 'read_noise'"),
        ("read_noise", {"rsm": 0.1}, "here: unknown key 'rsm'; did you mean 'rms'"),
        ("read_noise", {"rms": -0.1}, "here: rms = -0.1, at least 0 wanted"),
        ("quantisation", {"bits": 1.5}, "bits = 1.5, a whole number"),
        ("quantisation", {"bits": 60}, "from 0 to 48"),
        ("poisson_ratio", {"nu": 0.7}, "nu = 0.7, from 0 to 0.5"),
        ("finite_thickness", {"thickness_mm": 0}, "thickness = 0.0"),
        ("viscoelastic", {"parts": [[1, 2, 3]]}, "pairs wanted"),
        ("dead_taxels", {"dead": 0.7, "stuck": 0.7}, "stuck = 0.7"),
    )
    for name, given, message in wrong:
        with pytest.raises(InputError, match=message):
            read_effect(name, given, "here")
    with pytest.raises(InputError, match="thickness of at least the depth"):
        list(scene(effects=(("finite_thickness", FiniteThickness(1e-4)),)))


@pytest.mark.parametrize("name", ORDER)
def test_what_is_absurd_is_refused_and_what_is_huge_stays_a_number(name: str) -> None:
    kind = effect_class(name)
    values = np.random.default_rng(4).normal(size=(12, 3, 4, 3)) * 0.03
    for one in dataclasses.fields(kind):  # type: ignore[arg-type]  # its decorator makes it a dataclass
        if not isinstance(one.default, float | None):
            continue
        bad = [np.nan] if kind.NONE.get(one.name) == np.inf else [np.nan, np.inf, -np.inf]
        for value in bad:
            with pytest.raises(InputError, match=one.name):
                kind(**{one.name: value})
        for value in (1e300, -1e300, 1e-300):
            with contextlib.suppress(InputError):
                effect: Any = kind(**{one.name: value})
                if kind.STAGE == "frames":
                    assert np.isfinite(through(effect, values)).all(), (one.name, value)


def test_the_page_of_effects_has_every_effect_and_key() -> None:
    rows = [line for line in (ROOT / "docs" / "effects.md").read_text().splitlines() if line.startswith("| `")]
    assert [row.split("`")[1] for row in rows] == list(ORDER)
    for name, row in zip(ORDER, rows, strict=True):
        kind = effect_class(name)
        for key in kind.KEYS:
            assert f"`{key}` " in row, (name, key)
