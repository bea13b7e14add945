"""The command line `tactile`, as ``python -m tactile``."""

from importlib import import_module

# By name: the modules of this folder are floors below the command line, and nothing imports this one.
import_module("tactile.cli.group").main(prog_name="python -m tactile")
