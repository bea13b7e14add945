"""Names beside the points of a diagram, each where it touches no other name and no point."""

from collections.abc import Sequence
from typing import Any

_PLACES = tuple((dx, dy) for dy in (0, 7, -7, 14, -14, 21, -21, 28, -28, 35, -35) for dx in (4, -4))
"""Points (1/72 inch) from a point to its name, the nearest first; to the left its end is there."""
_WIDTH, _HEIGHT = 0.56, 1.15
"""Of a letter, and of a line, over the size of the font."""
_NEAR = 2.5
"""Points round a point that belong to it."""

Box = tuple[float, float, float, float]


def label_points(axes: Any, points: Sequence[tuple[float, float]], names: Sequence[str], size: float = 6) -> None:
    """Write names beside points; one that stands farther away is joined to its point by a thin line."""
    axes.figure.draw_without_rendering()  # the layout decides how many points there are to an inch of data
    scale = 72 / axes.figure.dpi
    at = [tuple(axes.transData.transform(point) * scale) for point in points]
    inside = axes.get_window_extent()
    left, right = inside.x0 * scale, inside.x1 * scale
    taken: list[Box] = [(x - _NEAR, y - _NEAR, x + _NEAR, y + _NEAR) for x, y in at]
    for (x, y), point, name in sorted(zip(at, points, names, strict=True), key=lambda one: -one[0][1]):
        boxes = [_box(x + dx, y + dy, dx < 0, name, size) for dx, dy in _PLACES]
        free = [
            n for n, box in enumerate(boxes)
            if left < box[0] and box[2] < right and not any(_touch(box, other) for other in taken)
        ]  # fmt: skip
        n = free[0] if free else 0
        dx, dy = _PLACES[n]
        taken.append(boxes[n])
        axes.annotate(
            name, point, xytext=(dx, dy), textcoords="offset points", fontsize=size, va="center",
            ha="right" if dx < 0 else "left", arrowprops={"arrowstyle": "-", "lw": 0.3, "shrinkA": 0} if dy else None,
        )  # fmt: skip


def _box(x: float, y: float, leftwards: bool, name: str, size: float) -> Box:
    width, height = _WIDTH * size * len(name), _HEIGHT * size
    start = x - width if leftwards else x
    return start, y - height / 2, start + width, y + height / 2


def _touch(one: Box, other: Box) -> bool:
    return one[0] < other[2] and other[0] < one[2] and one[1] < other[3] and other[1] < one[3]
