"""What every folder needs: the array types of annotations and the error for wrong input."""

from cnnsim.support.errors import InputError
from cnnsim.support.types import Array, Floats

__all__ = ["Array", "Floats", "InputError"]
