"""The library: templates as data, one TOML file a template, and how one is found, loaded and run."""

from cnnsim.library.catalogue import load, names, run, run_example
from cnnsim.library.folders import add, folder, using
from cnnsim.library.read import load_file

__all__ = ["add", "folder", "load", "load_file", "names", "run", "run_example", "using"]
