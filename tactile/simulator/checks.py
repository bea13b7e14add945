"""Range check of the effects' parameters."""

import math

from cnnsim.support import InputError


def within(name: str, value: float, low: float = 0.0, high: float = math.inf) -> None:
    """Refuse a value outside low .. high, both allowed.

    Raises:
        InputError: it is outside, or not a number.
    """
    if not low <= value <= high:
        wanted = f"at least {low:g}" if math.isinf(high) else f"from {low:g} to {high:g}"
        raise InputError(f"{name} = {value!r}, {wanted} wanted")
