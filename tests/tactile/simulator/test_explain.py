"""What a scene says about itself."""

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner

from tactile.cli.explain import explain as command
from tactile.cli.group import main
from tactile.core.frame import TaxelArray
from tactile.simulator.contacts.moving_load import MovingLoad
from tactile.simulator.effects import ORDER
from tactile.simulator.effects.dead_taxels import DeadTaxels
from tactile.simulator.effects.finite_tip import FiniteTip
from tactile.simulator.effects.motor_noise import MotorNoise
from tactile.simulator.effects.poisson_ratio import PoissonRatio
from tactile.simulator.effects.quantisation import Quantisation
from tactile.simulator.effects.read_noise import ReadNoise
from tactile.simulator.explain import explain, explain_file
from tactile.simulator.scene.scene import Scene
from tactile.simulator.scene_file.file import read_scene
from tactile.simulator.sizes import Sample, sizes_in
from tests.kits.paths import ROOT, SCENES
from tests.kits.touch.random_scenes import error, error_of_seeds, needle


def test_a_sample_of_a_long_scene_reaches_over_all_of_it() -> None:
    sample = Sample(needle(duration=100.0), 512)
    assert len(sample.numbers) == 512
    assert sample.numbers[[0, -1]].tolist() == [0, 9999]


def test_sizes_are_those_in_this_scene() -> None:
    # of what is fixed: what taking it away or adding it changes, the others as they are
    scene = read_scene(SCENES / "needle.toml")
    parts = {part.name: part for part in explain(scene).parts}
    sizes = {name: part.size for name, part in parts.items()}
    smooth = [one for one in scene.effects if one[0] != "quantisation"]
    for name in ("poisson_ratio", "finite_tip"):
        change = error(scene.with_effects([one for one in smooth if one[0] != name]), scene.with_effects(smooth))
        if parts[name].at_most:  # a few steps of the converter
            assert change <= sizes[name] <= change + 1.5e-3, name
        else:
            assert sizes[name] == pytest.approx(change, rel=1e-6), name
    # 0.093 under a point load on point taxels; the area feels the tip, not the point and a correction in its middle
    assert sizes["strain_nonlinearity"] == pytest.approx(0.019, abs=0.002)


def test_the_size_of_what_is_random_is_a_bound_over_seeds() -> None:
    scene = needle(("read_noise", ReadNoise(0.01)), ("poisson_ratio", PoissonRatio(0.4)), ("dead_taxels", DeadTaxels()))
    sizes = {part.name: part.size for part in explain(scene).parts}
    assert sizes["dead_taxels"] >= 1  # though none is dead with this seed
    plain = needle(("poisson_ratio", PoissonRatio(0.4)))
    most = error_of_seeds(
        plain, needle(("read_noise", ReadNoise(0.01)), ("poisson_ratio", PoissonRatio(0.4))), range(20)
    )
    assert most <= sizes["read_noise"] <= 1.6 * most


def test_a_bound_of_what_is_random_counts_the_steps_of_the_converter_behind_it() -> None:
    # 8 bits: a change below a step may become one
    coarse = ("quantisation", Quantisation(8, 1.5)), ("motor_noise", MotorNoise(1e-3))
    told = {part.name: part.size for part in explain(needle(*coarse)).parts}
    assert error_of_seeds(needle(coarse[0]), needle(*coarse), range(8)) <= told["motor_noise"]


def test_a_fixed_effect_before_a_coarse_converter_is_told_by_a_bound() -> None:
    # smaller than a step of the converter, which noise lets some readings cross: none with one seed, one with another
    coarse = ("read_noise", ReadNoise(2e-3)), ("quantisation", Quantisation(8, 1.5))
    scene, nearly = needle(*coarse), ("poisson_ratio", PoissonRatio(0.49995))
    (told,) = (part for part in explain(needle(nearly, *coarse)).parts if part.name == "poisson_ratio")
    step = 1.5 * 0.15 / 128 / Sample(scene).peak
    changes = [error_of_seeds(scene, needle(nearly, *coarse), [seed]) for seed in range(8)]
    assert min(changes) == 0
    assert max(changes) == pytest.approx(step)
    assert told.at_most
    assert step <= told.size <= 1.1 * step
    fine = explain(needle(("poisson_ratio", PoissonRatio(0.4)), ("quantisation", Quantisation(16, 1.5)))).parts
    assert not {part.name: part.at_most for part in fine}["poisson_ratio"]


@pytest.mark.parametrize("frames", (100, 9000))
def test_what_an_effect_does_for_a_moment_counts(frames: int) -> None:
    # a tap of three frames, which are not among 64 evenly spread ones nor among 4096
    at = (frames // 3 + 1) / 100
    light, hard = (0, 0, 0, 0, 1e-4), (0, 0, 0, 0, 0.02)
    path = np.array([(0.0, *light), (at - 0.01, *light), (at, *hard), (at + 0.01, *light), (frames / 100, *light)])
    scene = replace(needle(duration=frames / 100), loads=(MovingLoad(0, path),)).with_effects(())
    tip = ("finite_tip", FiniteTip(1e-4))
    size = sizes_in(scene, [tip])["finite_tip"]
    assert size.change == pytest.approx(error(scene, scene.with_effects([tip])), rel=1e-6)
    assert not size.at_most


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
    assert by_name["read_noise"].size == pytest.approx(4.8 * 0.01 * 0.15 / told.peak, rel=0.3)
    assert by_name["finite_tip"].size == pytest.approx(0.07, abs=0.05)  # the paper's needle on its cover
    assert told.notes == ()


def test_an_effect_without_meaning_in_a_scene_is_named_and_the_rest_is_explained(tmp_path: Path) -> None:
    """A needle on a layer is nearly as wide as its contact; typical stickiness would draw it in further."""
    text = (SCENES / "contacts.toml").read_text(encoding="utf-8")
    (tmp_path / "auto.toml").write_text(
        'effects = "auto"\ntolerance = 0.02\n' + text + "\n[effect.finite_thickness]\n", encoding="utf-8"
    )
    told = explain_file(tmp_path / "auto.toml", tmp_path / "kept.toml")
    assert "not computable in this scene at typical strength, not measured: adhesion" in told.notes[-1]
    assert "adhesion" not in {part.name for part in told.parts}
    assert {"taxel_area", "low_pass"} <= {part.name for part in told.parts}


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


@pytest.mark.parametrize("arguments", (["explain"], ["accuracy"]))
def test_a_recording_is_no_scene_and_the_command_that_takes_it_is_told(arguments: list[str]) -> None:
    result = CliRunner().invoke(main, [*arguments, str(ROOT / "examples" / "grasp.npz")])
    assert result.exit_code == 2
    assert "grasp.npz: suffix '.npz', a scene (.toml) wanted" in result.output
    assert "`tactile run " in result.output
