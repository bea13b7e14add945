"""Classification of slides by a texture model, and warnings about unusual slides."""

from typing import Any

from cnnsim.support import Floats
from tactile.materials.conditions import conditions_of
from tactile.materials.model import TextureModel
from tactile.materials.windows import WindowTable

SURE = 0.5
"""Least confidence of a predicted material."""
UNKNOWN = "unknown"


def strange(model: TextureModel, table: WindowTable) -> list[str]:
    """Return warnings: conditions outside of those of the training slides, or windows of the training set."""
    said, now = [], conditions_of(table, model.features.window)
    for name, known in model.conditions.items():
        if isinstance(known, list) and name in now and (now[name][0] > known[1] or now[name][1] < known[0]):
            have, want = (f"{one[0]:.3g} to {one[1]:.3g}" for one in (now[name], known))
            said.append(f"{name} {have}; the training slides have {want}")
    if model.known.holds(model.space(table.values)).mean() > 0.5:
        said.append("most of these windows are training windows; they do not measure the accuracy on others")
    return said


def told_slides(model: TextureModel, table: WindowTable, least: float) -> list[dict[str, Any]]:
    """Return for each slide the material with the largest mean vote, "unknown" below the ``least`` mean confidence."""
    shares, sure = model.tell(table)
    out: list[dict[str, Any]] = []
    for number, slide in enumerate(table.slides):
        mine = table.slide == number
        if not mine.any():
            out.append({"slide": slide.name, "known": slide.material, "told": None, "confidence": None, "windows": []})
            continue
        each = [
            {"start_s": float(slide.t[start]), "told": _told(model, share, c, least), "confidence": float(c)}
            for start, share, c in zip(table.start[mine], shares[mine], sure[mine], strict=True)
        ]
        confidence = float(sure[mine].mean())
        told = _told(model, shares[mine].mean(axis=0), confidence, least)
        whole = {"slide": slide.name, "known": slide.material, "told": told, "confidence": confidence}
        out.append(whole | {"windows": each})
    return out


def _told(model: TextureModel, shares: Floats, confidence: float, least: float) -> str:
    return model.materials[int(shares.argmax())] if confidence >= least else UNKNOWN
