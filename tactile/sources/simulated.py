"""Simulated frames as a source: scenes, whose home is ``tactile.simulator``."""

from tactile.simulator.contacts.moving_load import MovingLoad
from tactile.simulator.scene.file import read_scene, scene_from
from tactile.simulator.scene.scene import Scene

__all__ = ["MovingLoad", "Scene", "read_scene", "scene_from"]
