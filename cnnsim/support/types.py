"""Array types for annotations."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

Array = NDArray[Any]
"""An array of any numbers."""

Floats = NDArray[np.float64]
"""An array of float64 numbers."""

Integers = NDArray[np.int64]
"""An array of whole numbers."""

Flags = NDArray[np.bool_]
"""An array of truth values."""
