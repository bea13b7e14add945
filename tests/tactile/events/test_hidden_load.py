"""Loads between taxels at a distance of sqrt(2) depths, where the normal strain is zero: contact by location."""

import pytest

from cnnsim.support.toml_file import parse_toml
from tactile.events.event import Event
from tactile.simulator.scene_file.file import scene_from
from tests.kits.touch.made import events

SCENE = """
title = "amid four"
rate_hz = 100
duration_s = 3.0
[cover]
youngs_modulus_mpa = 2.4
quantity = "strain"
[[finger]]
name = "tip"
rows = {side}
cols = {side}
pitch_mm = {pitch}
depth_mm = 1.5
[[load]]
finger = "tip"
path = [[1.0, {at}, {at}, 0, 0, 0], [1.2, {at}, {at}, 0, 0, {force}], [2.0, {at}, {at}, 0, 0, {force}], [2.2, {at}, {at}, 0, 0, 0]]
[effect.read_noise]
rms = {noise}
"""  # noqa: E501 - a file


def press(pitch: float, side: int, force: float = 0.5, noise: float = 0.0, at: float = 0.0) -> list[Event]:
    text = SCENE.format(pitch=pitch, side=side, force=force, noise=noise, at=at)
    return events(scene_from(parse_toml(text, "here"), "here"))


@pytest.mark.parametrize("noise", [0.0, 2e-4])
@pytest.mark.parametrize(("pitch", "side"), [(3.0, 2), (2.9, 2), (3.1, 2), (3.0, 4)])
def test_a_load_without_normal_strain_is_a_contact(pitch: float, side: int, noise: float) -> None:
    """The normal strain is proportional to 2 z^2 - x^2 - y^2: 0 in the middle of four taxels 2 depths apart."""
    found = press(pitch, side, noise=noise)
    times = {kind: [event.t for event in found if event.kind == kind] for kind in ("contact", "release")}
    assert times["contact"] == [pytest.approx(1.05, abs=0.06)]
    assert times["release"] == [pytest.approx(2.15, abs=0.06)]


@pytest.mark.filterwarnings("ignore:.*above the dead band:UserWarning")
def test_a_small_load_and_one_outside_the_array_are_no_contact() -> None:
    assert [event.kind for event in press(3.0, 2, force=0.03)] == []
    assert [event.kind for event in press(1.5, 2, at=3.0)] == []
