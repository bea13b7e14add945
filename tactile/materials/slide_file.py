"""NPZ file of slides: concatenated forces, the length of each slide, and its material.

``force`` (sum of length, 3) [N]; ``length`` (slides,), samples of each; ``t`` (sum of length,) [s], which may
restart with each slide; optionally ``material`` (slides,), numbers or words, ``repeat`` (slides,), the order in
which a material's slides were recorded, ``block`` (slides,), ``speed_m_s`` (slides,) and ``axes``: which columns of
``force`` are shear_x, shear_y and normal. Without ``axes`` the normal is the column of the largest mean size, its sign
such that pressing is positive, and the shears are the others in their order.
"""

import zipfile
from pathlib import Path
from typing import Any

import numpy as np

from cnnsim.support import Floats, InputError
from cnnsim.support.array_files import read_npz_arrays
from cnnsim.support.limits import one_line
from tactile.materials.slide import Slide

NEEDED = ("force", "length", "t")
KNOWN = ("material", "repeat", "block", "speed_m_s")
BLOCKS = 5
"""Number of blocks of the slides of a material, if the file has none."""


def is_slide_file(path: Path) -> bool:
    """Return whether a file is an NPZ file of slides, by the names of its arrays."""
    if not path.is_file():
        return False
    try:
        with zipfile.ZipFile(path) as archive:
            return {f"{name}.npy" for name in NEEDED} <= set(archive.namelist())
    except (OSError, zipfile.BadZipFile, ValueError, NotImplementedError):  # of names and versions of damaged files
        return False


def read_slide_file(path: Path) -> list[Slide]:
    """Return the slides of an NPZ file; without ``block`` the slides of each material are split into fifths, in order.

    Raises:
        InputError: no such file, a missing array or one of the wrong shape.
    """
    found = read_npz_arrays(path, "file of slides", (*NEEDED, *KNOWN, "axes"))
    missing = [name for name in NEEDED if name not in found]
    if missing:
        raise InputError(f"{path}: {', '.join(missing)} missing; {', '.join(NEEDED)} wanted")
    with one_line(path, "an NPZ file of slides"):
        return _slides(found, path)


def _slides(found: dict[str, Any], path: Path) -> list[Slide]:
    length, count = found["length"], found["length"].size
    if length.ndim != 1 or not np.issubdtype(length.dtype, np.integer) or not count or (length < 1).any():
        raise InputError(f"{path}: length of shape {length.shape} and type {length.dtype}; (slides,) from 1 up wanted")
    total = int(length.sum())
    for name, shape in (("force", (total, 3)), ("t", (total,)), *((name, (count,)) for name in KNOWN)):
        if name in found and found[name].shape != shape:
            raise InputError(f"{path}: {name} of shape {found[name].shape}; {shape} wanted")
    force = _turned(found["force"].astype(np.float64), found.get("axes"), path)
    material = [str(one) for one in found.get("material", np.full(count, ""))]
    block = found["block"] if "block" in found else blocks(material, found.get("repeat", np.arange(count)))
    ends = np.cumsum(length)
    slides = []
    for n, (start, stop) in enumerate(zip(ends - length, ends, strict=True)):
        t = found["t"][start:stop].astype(np.float64)
        grows = np.concatenate([[True], np.diff(np.maximum.accumulate(t)) > 0])  # a stamp may come twice
        speed = float(found["speed_m_s"][n]) if "speed_m_s" in found else None
        name = f"{path.stem} {n}"
        slides.append(Slide(name, t[grows], force[start:stop][grows], material[n], int(block[n]), speed))
    return slides


def _turned(force: Floats, axes: Any, path: Path) -> Floats:
    """Return forces with the axes (shear_x, shear_y, normal), pressing positive."""
    if axes is None:
        normal = int(np.argmax(np.abs(np.nanmean(force, axis=0))))
        axes = [*(k for k in range(3) if k != normal), normal]
    said = np.asarray(axes).tolist()
    if sorted(said) != [0, 1, 2]:
        raise InputError(f"{path}: axes {said}; the columns 0, 1, 2 in the order of x, y, normal wanted")
    force = force[:, axes]
    sign = -1.0 if np.nanmean(force[:, 2]) < 0 else 1.0
    return force * (1.0, 1.0, sign)


def blocks(material: list[str], order: Any) -> list[int]:
    """Return for each slide which part of its material's slides it belongs to, these in their order."""
    out = [0] * len(material)
    for name in set(material):
        mine = sorted((n for n, one in enumerate(material) if one == name), key=lambda n: order[n])
        for rank, n in enumerate(mine):
            out[n] = rank * BLOCKS // len(mine)
    return out
