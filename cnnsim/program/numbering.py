"""Numbers of the steps of a program, and rows of a table of them."""

from collections.abc import Iterator
from typing import Any


def numbered(steps: tuple[Any, ...], prefix: str = "") -> Iterator[tuple[str, Any]]:
    """Yield (number, step) of all steps, those inside others after these, under the numbers that messages have."""
    for number, step in enumerate(steps, start=1):
        here = f"{prefix}{number}"
        yield here, step
        yield from numbered(getattr(step, "do", ()), f"{here}.")
        yield from numbered(getattr(step, "otherwise", ()), f"{here} otherwise ")


def step_rows(steps: tuple[Any, ...]) -> Iterator[tuple[str, str, str]]:
    """Yield (number, description, names written) of all steps."""
    for number, step in numbered(steps):
        to = getattr(step, "to", "")
        yield number, str(step), to if isinstance(to, str) else ", ".join(to)


def written(value: float | str) -> str:
    """Return a name, or a number as it is written."""
    return value if isinstance(value, str) else f"{value:g}"
