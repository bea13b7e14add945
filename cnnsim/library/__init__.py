"""Template library: TOML files of templates, found by name, loaded and run."""

from cnnsim.library.catalogue import load, names, run, run_example
from cnnsim.library.folders import add, folder, using
from cnnsim.library.read import load_file

__all__ = ["add", "folder", "load", "load_file", "names", "run", "run_example", "using"]
