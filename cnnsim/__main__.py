"""The command line `cnnsim`, as ``python -m cnnsim``."""

from cnnsim.start import start

start("cnnsim.cli.group", "python -m cnnsim")
