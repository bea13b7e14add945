"""What a scene says about itself, and effects chosen by their size."""

import json
from typing import Any

import numpy as np
import pytest
from click.testing import CliRunner

from cnnsim.support import InputError
from tactile.cli.explain import explain as command
from tactile.core.frame import TaxelArray
from tactile.simulator.contacts.moving_load import MovingLoad
from tactile.simulator.effects import ORDER, effect_class, without
from tactile.simulator.effects.crosstalk import Crosstalk
from tactile.simulator.effects.dead_taxels import DeadTaxels
from tactile.simulator.effects.drift import Drift
from tactile.simulator.effects.finite_thickness import FiniteThickness
from tactile.simulator.effects.finite_tip import FiniteTip
from tactile.simulator.effects.frame_timing import FrameTiming
from tactile.simulator.effects.hysteresis import Hysteresis
from tactile.simulator.effects.motor_noise import MotorNoise
from tactile.simulator.effects.needle_vibration import NeedleVibration
from tactile.simulator.effects.poisson_ratio import PoissonRatio
from tactile.simulator.effects.quantisation import Quantisation
from tactile.simulator.effects.read_noise import ReadNoise
from tactile.simulator.effects.strain_nonlinearity import StrainNonlinearity
from tactile.simulator.effects.surface_waviness import SurfaceWaviness
from tactile.simulator.effects.taxel_area import TaxelArea
from tactile.simulator.effects.viscoelastic import Viscoelastic
from tactile.simulator.scene.auto_effects import choose
from tactile.simulator.scene.estimate import Sample
from tactile.simulator.scene.explain import explain, explain_file
from tactile.simulator.scene.file import read_scene
from tactile.simulator.scene.scene import Scene
from tests.kits.paths import SCENES

QUIET = [(name, without(effect_class(name))) for name in ORDER]
"""Every effect at strength zero: candidates that only the tests turn up."""


def needle(*effects: tuple[str, Any], duration: float = 1.0, seed: int = 0) -> Scene:
    path = np.array([(0.0, -3e-4, 1e-4, 0.002, 0, 0.02), (duration, 3e-4, 0, -0.002, 0.001, 0.015)])
    array, chosen = TaxelArray("chip", 2, 2, 4e-4, 2e-4), dict(QUIET) | dict(effects)
    return Scene("n", 100.0, duration, 2.4e6, (array,), (MovingLoad(0, path),), (), tuple(chosen.items()), 0.15, seed)


def everything(scene: Scene) -> list[tuple[str, Any]]:
    named = dict(scene.effects)
    return [(name, named.get(name) or effect_class(name)()) for name in ORDER]


def error(one: Scene, other: Scene) -> float:
    """Largest difference of two scenes over all their frames, relative to the ideal skin's peak."""
    samples = Sample(one)
    a, b = ([list(scene.batches(finger)) for finger in range(len(scene.arrays))] for scene in (one, other))
    largest = 0.0
    for finger in range(len(one.arrays)):
        times = np.arange(one.samples) / one.rate
        sides = []
        for side in (a, b):
            t = np.concatenate([batch.t for batch in side[finger]])
            read = np.concatenate([batch.values for batch in side[finger]]).reshape(len(t), -1)
            t, first = np.unique(t, return_index=True)
            sides.append(np.stack([np.interp(times, t, column) for column in read[first].T]))
        largest = max(largest, float(np.abs(sides[0] - sides[1]).max()))
    return largest / samples.peak


def test_auto_keeps_exactly_what_exceeds_the_tolerance() -> None:
    for rms, kept in ((0.02, True), (0.0001, False)):
        choice = choose(needle(("read_noise", ReadNoise(rms)), ("poisson_ratio", PoissonRatio(0.3))), 0.02)
        assert [name for name, _ in choice.scene.effects] == ["poisson_ratio", "read_noise"][: 1 + kept]
        assert (choice.sizes["read_noise"] > 0.02) == kept
        assert ("read_noise" in choice.left_out) != kept
        assert choice.together == ()
        assert set(choice.left_out) | dict(choice.scene.effects).keys() == set(ORDER)
        assert choice.joint <= 0.02
    assert choose(needle(), 0.02).scene.effects == ()
    with pytest.raises(InputError, match="tolerance 0"):
        choose(needle(), 0)


def test_small_effects_that_add_up_are_not_all_left_out() -> None:
    # both take a little from the normal strain
    small = ("viscoelastic", Viscoelastic(((0.018, 0.01),))), ("strain_nonlinearity", StrainNonlinearity(0.2))
    choice = choose(needle(*small), 0.02)
    assert max(choice.sizes.values()) <= 0.02
    assert len(choice.together) >= 1
    assert choice.joint <= 0.02


def test_undescribed_effects_count_at_their_typical_strength() -> None:
    bare = needle()
    bare = bare.with_effects(())
    choice = choose(bare, 0.02)
    assert choice.sizes["finite_tip"] > 0.02
    assert dict(choice.scene.effects)["finite_tip"] == FiniteTip()


def random_scene(random: np.random.Generator) -> Scene:
    """Any effect at any strength, from far below to far above the tolerance, and any load."""

    def some(low: float, high: float) -> float:
        return float(np.exp(random.uniform(np.log(low), np.log(high))))

    effects: list[tuple[str, Any]] = [
        ("needle_vibration", NeedleVibration(some(1e-9, 3e-6), some(1e-9, 1e-6))),
        ("surface_waviness", SurfaceWaviness(some(1e-9, 2e-6), some(2e-4, 2e-3))),
        ("poisson_ratio", PoissonRatio(0.5 - some(1e-4, 0.4))),
        ("finite_tip", FiniteTip(some(2e-6, 1e-4))),
        ("finite_thickness", FiniteThickness(2e-4 * some(1.2, 50))),
        ("taxel_area", TaxelArea(some(5e-6, 3e-4))),
        ("strain_nonlinearity", StrainNonlinearity(some(1e-3, 1))),
        ("viscoelastic", Viscoelastic(((some(1e-4, 0.2), some(1e-2, 10)),))),
        ("hysteresis", Hysteresis(some(1e-3, 0.5), some(1e-2, 0.3))),
        ("crosstalk", Crosstalk(some(1e-4, 0.1), some(1e-4, 0.1))),
        ("motor_noise", MotorNoise(some(1e-5, 0.05))),
        ("drift", Drift(some(1e-5, 0.05), some(1e-5, 0.05))),
        ("read_noise", ReadNoise(some(1e-5, 0.02))),
        ("dead_taxels", DeadTaxels(some(1e-3, 0.1), some(1e-3, 0.1))),
        ("quantisation", Quantisation(int(random.integers(6, 17)), 2.0)),
        ("frame_timing", FrameTiming(some(1e-6, 1e-3), some(1e-5, 1e-2), some(1e-5, 1e-2))),
    ]
    duration = some(0.3, 3.5)  # one in eight has more frames than the sample
    x, y = random.uniform(-4e-4, 4e-4, (2, 2))
    path = np.array(
        [
            (0.0, x[0], y[0], *random.uniform(-5e-3, 5e-3, 2), some(1e-3, 0.03)),
            (duration, x[1], y[1], *random.uniform(-5e-3, 5e-3, 2), some(1e-3, 0.03)),
        ]
    )
    array = TaxelArray("chip", 2, 2, 4e-4, 2e-4)
    seed = int(random.integers(1000))
    return Scene("r", 50.0, duration, 2.4e6, (array,), (MovingLoad(0, path),), (), tuple(effects), 0.15, seed)


def test_the_error_stays_within_the_tolerance_in_95_of_100_random_scenes(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("tactile.simulator.scene.estimate.FRAMES", 128)
    random, good, kept = np.random.default_rng(2), 0, 0
    for _ in range(100):
        scene = random_scene(random)
        choice = choose(scene, 0.02)
        kept += len(choice.scene.effects)
        good += error(choice.scene, scene.with_effects(everything(scene))) <= 0.02
        for name, size in choice.sizes.items():
            on = name in dict(choice.scene.effects)
            assert on == (size > 0.02 or name in choice.together)
    assert good >= 95
    assert 300 < kept < 1500  # neither nothing nor everything


def test_a_sample_of_a_long_scene_reaches_over_all_of_it() -> None:
    sample = Sample(needle(duration=100.0))
    assert len(sample.numbers) == 512
    assert sample.numbers[[0, -1]].tolist() == [0, 9999]
    assert sample.stretch > 1
    assert Sample(needle()).stretch == 1
    noisy = choose(needle(("read_noise", ReadNoise(0.002)), duration=100.0), 1e-9).sizes["read_noise"]
    plain, loud = (
        values.reshape(-1)
        for values in (
            everyone(needle(duration=100.0)),
            everyone(needle(("read_noise", ReadNoise(0.002)), duration=100.0)),
        )
    )
    assert noisy == pytest.approx(np.abs(loud - plain).max() / sample.peak, rel=0.25)


def everyone(scene: Scene) -> Any:
    return np.concatenate([batch.values for batch in scene.batches(0)])


def test_an_explanation_names_every_part() -> None:
    told = explain(needle(("read_noise", ReadNoise(0.01))).with_effects([("read_noise", ReadNoise(0.01))]))
    assert [part.name for part in told.parts] == ["contacts", "field", *ORDER]
    by_name = {part.name: part for part in told.parts}
    assert {name for name, part in by_name.items() if part.on} == {"contacts", "field", "read_noise"}
    for part in told.parts:
        assert (part.seconds is None) != part.on
        assert part.size >= 0
    assert by_name["read_noise"].seconds is not None
    assert 0 < by_name["read_noise"].seconds < 1e-3
    assert by_name["read_noise"].size == pytest.approx(4 * 0.01 * 0.15 / told.peak, rel=0.3)
    assert by_name["finite_tip"].size == pytest.approx(0.07, abs=0.05)  # the paper's needle on its cover
    assert told.notes == ()


def test_a_scene_without_load_is_explained_too() -> None:
    array, path = TaxelArray("a", 2, 2, 1e-3, 1e-3), np.array([(0.0, 0, 0, 0, 0, 0.0)])
    told = explain(Scene("quiet", 10.0, 0.1, 1e6, (array,), (MovingLoad(0, path),)))
    assert all(np.isfinite(part.size) for part in told.parts)


def test_the_command_prints_a_tree_or_json() -> None:
    done = CliRunner().invoke(command, [str(SCENES / "textures.toml")])
    assert done.exit_code == 0, done.output
    for word in (
        "screw, smooth wood",
        "left out, with the bound",
        "on: size",
        "off: what",
        "read_noise",
        "method: direct",
    ):
        assert word in done.output
    done = CliRunner().invoke(command, [str(SCENES / "needle.toml"), "--json"])
    told = json.loads(done.output)
    on = {part["name"] for part in told["parts"] if part["on"]}
    assert on == {"contacts", "field"} | {name for name, _ in read_scene(SCENES / "needle.toml").effects}
    assert explain_file(SCENES / "grip.toml").title.startswith("grip")


def test_no_line_is_cut_where_the_output_is_no_terminal() -> None:
    done = CliRunner().invoke(command, [str(SCENES / "needle.toml")])
    lines = [line.rstrip() for line in done.output.splitlines()]
    assert max(map(len, lines)) > 120
    assert all(line == shown for line, shown in zip(done.output.splitlines(), lines, strict=True))  # and none is padded
    told = explain_file(SCENES / "needle.toml")
    for part in (*told.lines, *(part.what for part in told.parts)):
        assert any(line.endswith(part) for line in lines), part
    assert len(lines) == 3 + len(told.lines) + len(told.parts) + len(told.notes)
