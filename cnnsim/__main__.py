"""The command line `cnnsim`, as ``python -m cnnsim``."""

from importlib import import_module

# By name: the modules of this folder are floors below the command line, and nothing imports this one.
import_module("cnnsim.cli.group").main(prog_name="python -m cnnsim")
