"""Choices of effects that are written as scene files."""

import tomllib
from pathlib import Path
from typing import Any

import pytest
from click.testing import CliRunner

from cnnsim.support import InputError
from tactile.cli.explain import explain as command
from tactile.simulator.auto_effects import choose
from tactile.simulator.scene_file.file import bare_scene, read_scene, scene_table
from tactile.simulator.scene_file.kept_choice import write_choice
from tests.kits.paths import SCENES


def test_a_choice_is_kept_and_reused(tmp_path: Path) -> None:
    kept = tmp_path / "kept.toml"
    done = CliRunner().invoke(command, [str(SCENES / "textures.toml"), "--write", str(kept)])
    assert done.exit_code == 0, done.output
    table = scene_table(SCENES / "textures.toml")
    scene, tolerance = bare_scene(table, "textures", SCENES)
    assert tolerance is not None
    chosen = choose(scene, tolerance, reused=True).scene
    again = read_scene(kept)
    assert (again.effects, again.accuracy) == (chosen.effects, chosen.accuracy)
    assert again.loads == chosen.loads
    assert len(again.contacts) == len(chosen.contacts)
    text = kept.read_text(encoding="utf-8")
    assert "auto" not in text.split("\n# Effects chosen")[0].split("[cover]")[0].split("\n\n", 1)[1]
    assert "Left out" in text
    done = CliRunner().invoke(command, [str(kept), "--write", str(tmp_path / "more.toml")])
    assert "effects = 'auto' wanted" in str(done.exception)


def test_a_file_whose_effects_cannot_be_taken_out_by_lines_is_refused(tmp_path: Path) -> None:
    text = (SCENES / "needle.toml").read_text(encoding="utf-8").split("[effect.")[0]
    path: Any = tmp_path / "inline.toml"
    path.write_text('effects = "auto"\neffect.read_noise.rms = 0.01\n' + text, encoding="utf-8")
    done = CliRunner().invoke(command, [str(path), "--write", str(tmp_path / "kept.toml")])
    assert "[effect.NAME] wanted" in str(done.exception)


def test_a_choice_is_kept_beside_its_scene_and_the_files_it_reads(tmp_path: Path) -> None:
    text = (SCENES / "textures.toml").read_text(encoding="utf-8")
    path = tmp_path / "scene.toml"
    path.write_text(text, encoding="utf-8")
    done = CliRunner().invoke(command, [str(path), "--write", str(path)], standalone_mode=False)
    assert "the name of the scene itself; another name wanted" in str(done.exception)
    assert path.read_text(encoding="utf-8") == text
    table = tomllib.loads(text) | {"contact": [{"shape": "height_map", "file": "key.npy"}]}
    with pytest.raises(InputError, match="reads files of its folder"):
        write_choice(path, table, choose(read_scene(SCENES / "needle.toml"), 0.1), tmp_path / "other" / "kept.toml")
