"""Duration of a transient: a number of time constants, or until the network has settled."""

from typing import Literal

Duration = float | Literal["settled"]
