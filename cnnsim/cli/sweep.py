"""The command `sweep` of cnnsim: its kinds of sweep, each with its module."""

from cnnsim.sweep.command import sweep_command

KINDS = {"transients": "cnnsim.sweep.transients"}

sweep = sweep_command(KINDS, "cnnsim", "study.toml", "density,black,template")
