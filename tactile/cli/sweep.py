"""Command `sweep` of the tactile layer: its kinds of sweep, each with its module."""

from cnnsim.sweep.command import sweep_command

KINDS = {"scenes": "tactile.sweeps.scenes", "labelled": "tactile.sweeps.labelled"}

sweep = sweep_command(KINDS, "tactile", "grips.toml", "seed,frames")
