"""Simulated frames as a source: scenes, whose home is ``tactile.simulator``."""

from tactile.simulator.contacts import MovingLoad
from tactile.simulator.scene import Scene
from tactile.simulator.scene_file import read_scene, scene_from

__all__ = ["MovingLoad", "Scene", "read_scene", "scene_from"]
