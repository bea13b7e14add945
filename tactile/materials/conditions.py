"""Recording conditions of slides: rate, pressing, direction and speed."""

from typing import Any

import numpy as np

from tactile.materials.windows import WindowTable


def conditions_of(table: WindowTable, window: int) -> dict[str, Any]:
    """Return the recording conditions of slides, each as its 5 and 95 % points over the windows."""
    rows = []
    for slide, start in zip(table.slide.tolist(), table.start.tolist(), strict=True):
        one = table.slides[slide]
        t, force = one.t[start : start + window], one.force[start : start + window].mean(axis=0)
        angle = np.degrees(np.arctan2(force[1], force[0])) if force[:2].any() else np.nan
        rows.append(((window - 1) / (t[-1] - t[0]), force[2], angle, one.speed or np.nan))
    low, high = np.percentile(np.array(rows), (5, 95), axis=0)
    named = zip(("rate_hz", "normal", "shear_direction_deg", "speed_m_s"), low.tolist(), high.tolist(), strict=True)
    out: dict[str, Any] = {name: [a, b] for name, a, b in named if np.isfinite(a)}
    return out | {"slides": len(set(table.slide.tolist())), "windows": len(rows)}
