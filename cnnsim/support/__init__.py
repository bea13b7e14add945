"""Common parts of both packages: array types, the error for wrong input, diagnostics of files."""

from cnnsim.support.diagnostics import Diagnostics
from cnnsim.support.errors import InputError, naming
from cnnsim.support.types import Array, Flags, Floats, Integers

__all__ = ["Array", "Diagnostics", "Flags", "Floats", "InputError", "Integers", "naming"]
