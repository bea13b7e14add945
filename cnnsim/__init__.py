"""The cellular wave machine: planes, templates and programs of a cellular neural network.

from cnnsim import library, read_picture, run, write_picture
picture = read_picture("square.png")
result = run("edge", picture)
write_picture(result.y, "edge.png")
"""

from cnnsim import library
from cnnsim.library.catalogue import run
from cnnsim.network.boundary import PERIODIC, ZERO_FLUX, Boundary, fixed
from cnnsim.network.template import Template
from cnnsim.support.errors import InputError
from cnnsim.support.picture import read_picture, write_picture
from cnnsim.transient import NotSettledError, Result, run_transient

__all__ = [
    "PERIODIC",
    "ZERO_FLUX",
    "Boundary",
    "InputError",
    "NotSettledError",
    "Result",
    "Template",
    "fixed",
    "library",
    "read_picture",
    "run",
    "run_transient",
    "write_picture",
]
