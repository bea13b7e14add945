"""The command line `tactile`, as ``python -m tactile``."""

from cnnsim.start import start

start("tactile.cli.group", "python -m tactile")
