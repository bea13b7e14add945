"""Common parts of both packages: array types, the error for wrong input, diagnostics of files."""

from cnnsim.support.errors import Diagnostics, InputError, naming
from cnnsim.support.values import Array, Flags, Floats, Integers

__all__ = ["Array", "Diagnostics", "Flags", "Floats", "InputError", "Integers", "naming"]
