"""The command `sweep` of the tactile layer: its kinds of sweep, each with its module."""

from cnnsim.sweep.command import sweep_command

KINDS = {"scenes": "tactile.sweeps.scenes"}

sweep = sweep_command(KINDS, "tactile")
