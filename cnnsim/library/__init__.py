"""The library: templates as data, one TOML file a template, and how one is found, loaded and run."""

from cnnsim.library.catalogue import load, load_file, names, run, run_example
from cnnsim.library.folders import add, folder, using

__all__ = ["add", "folder", "load", "load_file", "names", "run", "run_example", "using"]
