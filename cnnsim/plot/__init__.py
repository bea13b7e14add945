"""Plots with matplotlib: each function draws into the given or new axes and returns them."""

from cnnsim.plot.animation import animation
from cnnsim.plot.figures import to_png
from cnnsim.plot.matrices import template
from cnnsim.plot.planes import plane, sheet
from cnnsim.plot.states import outputs, states

__all__ = ["animation", "outputs", "plane", "sheet", "states", "template", "to_png"]
