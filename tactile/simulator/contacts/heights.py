"""Height maps of bodies from arrays, or projected from the triangles of an STL file."""

from pathlib import Path

import numpy as np

from cnnsim.support import Floats, InputError
from cnnsim.support.array_files import read_array
from cnnsim.support.limits import check_file, one_line

MOST = 1 << 18
"""Most cells of a height map."""
LARGEST = 2**26
"""Most bytes of an STL file: 1.3 million triangles."""


def read_heights(path: Path, pitch: float, unit: float = 1e-3) -> Floats:
    """Return the heights (rows, cols) [m] of a body's underside, rows along y, from an .npy or .stl file.

    Arguments: ``unit`` [m] of the file; ``pitch`` [m] of the cells.

    Raises:
        InputError: no such file, contents of another kind than its suffix, heights that are not finite, over 262 144
            cells.
    """
    if path.suffix.lower() == ".stl":
        return cast_heights(read_stl(path) * unit, pitch)
    with one_line(path, "an array of heights"):
        heights = np.asarray(read_array(path), dtype=np.float64) * unit
    if heights.ndim != 2 or not heights.size or not np.isfinite(heights).all():
        raise InputError(f"{path}: heights of shape {heights.shape}; finite (rows, cols) wanted")
    _check(heights.shape)
    return heights


def read_stl(path: Path) -> Floats:
    """Return the triangles (n, 3 corners, 3) of an STL file, binary or text, in its own unit.

    Raises:
        InputError: no such file, not an STL file.
    """
    try:
        check_file(path, "body", LARGEST)
        raw = path.read_bytes()
    except OSError as error:
        raise InputError(f"{path}: cannot be read: {error}") from error
    count = int.from_bytes(raw[80:84], "little") if len(raw) >= 84 else -1
    if len(raw) == 84 + 50 * count and count > 0:
        rows = np.frombuffer(raw, np.dtype([("n", "<f4", 3), ("at", "<f4", (3, 3)), ("more", "<u2")]), count, 84)
        triangles = rows["at"].astype(np.float64)
    else:
        words = [line.split() for line in raw.decode("ascii", "replace").splitlines()]
        try:
            corners = [[float(x) for x in word[1:4]] for word in words if word[:1] == ["vertex"]]
            triangles = np.array(corners, dtype=np.float64).reshape(-1, 3, 3)
        except ValueError as error:
            raise InputError(f"{path}: no STL file; triangles of three vertices wanted") from error
    if not len(triangles) or not np.isfinite(triangles).all():
        raise InputError(f"{path}: no triangles; an STL file wanted")
    return triangles


def cast_heights(triangles: Floats, pitch: float) -> Floats:
    """Return the lowest point over each cell's middle, cells of a ``pitch`` [m]; outside the body heights out of reach.

    Arguments: ``triangles`` (n, 3, 3) [m], z up from the cover, the body's lowest point touching it first.

    Raises:
        InputError: over 262 144 cells.
    """
    low, high = triangles.min(axis=(0, 1)), triangles.max(axis=(0, 1))
    cols, rows = (max(1, int(n)) for n in np.minimum(np.ceil((high - low)[:2] / pitch), 2.0**53))
    _check((rows, cols))
    first = (low + high)[:2] / 2 - pitch * (np.array([cols, rows]) - 1) / 2
    heights = np.full((rows, cols), np.inf)
    ends = triangles[:, :, :2]
    starts = np.ceil((ends.min(axis=1) - first) / pitch - 1e-9).astype(int).clip(0)
    stops = np.floor((ends.max(axis=1) - first) / pitch + 1e-9).astype(int)
    (bx, by), (cx, cy) = ((ends[:, k] - ends[:, 0]).T for k in (1, 2))
    wholes = bx * cy - cx * by
    # the others stand upright, or lie between the cells' middles
    for n in np.flatnonzero((wholes != 0) & (stops >= starts).all(axis=1)).tolist():
        (a, b, c), start, stop, whole = triangles[n], starts[n], stops[n], wholes[n]
        x, y = np.meshgrid(*(first[k] + pitch * np.arange(start[k], stop[k] + 1) for k in (0, 1)))
        u = ((x - a[0]) * (c[1] - a[1]) - (c[0] - a[0]) * (y - a[1])) / whole
        v = ((b[0] - a[0]) * (y - a[1]) - (x - a[0]) * (b[1] - a[1])) / whole
        z = a[2] + u * (b[2] - a[2]) + v * (c[2] - a[2])
        here = heights[start[1] : stop[1] + 1, start[0] : stop[0] + 1]
        inside = (u >= -1e-9) & (v >= -1e-9) & (u + v <= 1 + 1e-9)
        np.minimum(here, np.where(inside, z, np.inf)[: here.shape[0], : here.shape[1]], out=here)
    # out of reach: higher than the body is, by as much as it is wide
    return np.where(np.isfinite(heights), heights, high[2] + float((high - low).max()))


def _check(shape: tuple[int, ...]) -> None:
    if shape[0] * shape[1] > MOST:
        raise InputError(f"a height map of {shape[0]} x {shape[1]} cells; at most {MOST} wanted (a larger pitch)")
