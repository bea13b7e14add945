"""Texture model files: NPZ with plain arrays and JSON; nothing in it is executed."""

import json
from pathlib import Path
from typing import Any

import numpy as np

from cnnsim.support import InputError
from cnnsim.support.array_files import read_npz_arrays
from cnnsim.support.files import make_folder, writing
from cnnsim.support.limits import one_line
from tactile.materials.features import BANDS, FINE, FeatureSet
from tactile.materials.model import Confidence, TextureModel
from tactile.materials.nearest_neighbours import KnownWindows, Space

FORMAT, VERSION = "tactile texture model", 1
ARRAYS = ("frequencies", "centre", "scale", "landmarks", "root", "projection", "places", "material")


def check_suffix(path: Path) -> None:
    """Refuse a file name without the suffix of a model.

    Raises:
        InputError: another suffix than .npz.
    """
    if path.suffix.lower() != ".npz":
        raise InputError(f"{path}: suffix {path.suffix!r}; .npz wanted for a model")


def write_model(path: Path, model: TextureModel, replace: bool | None = None) -> None:
    """Write a model to ``path`` (.npz).

    Raises:
        InputError: another suffix, an existing file, or a full disk.
    """
    check_suffix(path)
    features, space, sure = model.features, model.space, model.confidence
    head = {
        "format": FORMAT, "version": VERSION, "materials": model.materials, "features": features.kind,
        "names": features.names, "window": features.window, "spacing": features.spacing, "by_way": features.by_way,
        "shear": features.shear,
        "gamma": space.gamma, "weight": space.weight, "confidence": [sure.offset, sure.vote, sure.distance],
        "conditions": dict(model.conditions),
    }  # fmt: skip
    values = (
        features.frequencies, space.centre, space.scale, space.landmarks, space.root, space.projection,
        model.known.places, model.known.material,
    )  # fmt: skip
    arrays: dict[str, Any] = dict(zip(ARRAYS, values, strict=True))
    make_folder(path.parent)
    with writing(path, replace=replace) as beside, beside.open("wb") as file:
        np.savez_compressed(file, head=np.array(json.dumps(head)), **arrays)


def read_model(path: Path) -> TextureModel:
    """Read a model.

    Raises:
        InputError: no such file, no model, a newer version, a damaged or missing part.
    """
    arrays = read_npz_arrays(path, "texture model", ("head", *ARRAYS))
    if missing := [name for name in ("head", *ARRAYS) if name not in arrays]:
        raise InputError(f"{path}: {', '.join(missing)} missing; a texture model wanted")
    with one_line(path, "a texture model"):
        head = json.loads(str(arrays.pop("head")))
        if not isinstance(head, dict) or (head.get("format"), head.get("version")) != (FORMAT, VERSION):
            raise InputError(f"{path}: its head is not that of a {FORMAT} of version {VERSION}, which is wanted")
        return _model(head, arrays)


def _model(head: dict[str, Any], arrays: dict[str, Any]) -> TextureModel:
    """Return the model of a header and arrays; ``ValueError`` and similar where they are inconsistent."""
    material = arrays.pop("material")
    floats = {name: np.asarray(one, np.float64) for name, one in arrays.items()}
    if not np.issubdtype(material.dtype, np.integer) or not all(np.isfinite(one).all() for one in floats.values()):
        raise ValueError("numbers that are not finite, or materials that are no whole numbers")
    materials = tuple(str(one) for one in head["materials"])
    window, spacing = int(head["window"]), float(head["spacing"])
    kind = {"figures": "figures", "full": "full"}[head["features"]]
    features = FeatureSet(kind, window, floats["frequencies"], spacing, bool(head["by_way"]), head.get("shear", True))  # type: ignore[arg-type]  # of a dictionary
    size, marks = len(features.names), len(floats["landmarks"])
    wide, joined = floats["projection"].shape[-1], size + marks
    known = len(floats["places"])
    wanted = {
        "frequencies": (BANDS * FINE,), "centre": (size,), "scale": (size,), "landmarks": (marks, size),
        "root": (marks, marks), "projection": (joined, wide), "places": (known, wide),
    }  # fmt: skip
    for name, shape in wanted.items():
        if floats[name].shape != shape:
            raise ValueError(f"{name} of shape {floats[name].shape}; {shape} wanted")
    inside = known > 0 and material.shape == (known,) and material.min() >= 0 and material.max() < len(materials)
    if not inside or len(set(materials)) < len(materials) or window < 2 or not spacing > 0:
        raise ValueError("materials, windows and their numbers do not fit together")
    space = Space(
        floats["centre"], floats["scale"], floats["landmarks"], floats["root"], float(head["gamma"]),
        float(head["weight"]), floats["projection"],
    )  # fmt: skip
    sure = Confidence(*(float(one) for one in head["confidence"]))
    near = KnownWindows(floats["places"], material.astype(np.int64), len(materials))
    return TextureModel(materials, features, space, near, sure, dict(head["conditions"]))
