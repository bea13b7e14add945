"""Reports, arrays, scales and events as plain data for the page of the live array view."""

from typing import Any

import numpy as np

from cnnsim.studio.colours import indices
from tactile.calibration.tare_check import UNITS
from tactile.core.frame import TaxelArray
from tactile.events.event import Event
from tactile.inverse.validity import Validity
from tactile.output.collected import texture_mean
from tactile.output.event_data import finite, load_data
from tactile.output.plane import SURE, round_number
from tactile.studio.feed import Feed, Kept

_VALIDITY = {Validity.NOT_ONE: "no single point load", Validity.AMBIGUOUS: "uncertain: ambiguous"}
"""Words of the pictures."""


def array_data(array: TaxelArray) -> dict[str, Any]:
    """Return an array as plain data."""
    factor, unit = UNITS[array.quantity]
    return {
        "name": array.name, "rows": array.rows, "cols": array.cols, "pitch": array.pitch, "depth": array.depth,
        "origin": array.origin, "quantity": array.quantity, "factor": factor, "unit": unit,
        "inward": 1 if array.quantity == "force" else -1,
    }  # fmt: skip


def finger_data(row: Kept, buffers: list[bytes]) -> dict[str, Any]:
    """Return a report as plain data; its values (rows, cols, 3) and the planes of programs go to the buffers."""
    report, code = row.report, row.report.code
    values = np.where(report.frame.valid[..., None], report.frame.values, np.nan)
    buffers.append(values.astype(np.float32).tobytes())
    load, outputs = load_data(report.load), []
    for program, named in row.outputs.items():
        for name, value in named.items():
            plane = np.asarray(value)
            if plane.ndim == 2:
                logic = plane.dtype.kind == "b"
                buffers.append(indices(np.nan_to_num(np.where(plane, 1.0, -1.0) if logic else plane)).tobytes())
                outputs.append({"program": program, "name": name, "shape": plane.shape})
            else:
                outputs.append({"program": program, "name": name, "value": plane.ravel()[:8].tolist()})
    if load is not None:
        load["sure"] = report.load.validity in SURE
    validity = Validity(report.load.validity)
    bits = "".join("1" if sign == "+" else "0" for sign in code.ternary())
    return {
        "t": row.t, "load": load, "arrows": code.arrows(), "bits": bits, "contact": int(code.contact.sum()),
        "validity": _VALIDITY.get(validity) or validity.name.lower().replace("_", " "), "outputs": outputs,
        "friction": finite(texture_mean(report.texture.friction, report.texture.valid)),
        "roughness": finite(texture_mean(report.texture.roughness, report.texture.valid)),
    }  # fmt: skip


def scale_data(feed: Feed, array: TaxelArray) -> dict[str, float]:
    """Return the largest normal and shear of an array's quantity, and a round shear for the key of the arrows."""
    normal, shear = feed.largest(array.quantity)
    factor = UNITS[array.quantity][0]
    return {"normal": normal, "shear": shear, "key": round_number(shear * factor) / factor}


def span_data(event: Event) -> dict[str, Any]:
    """Return the span of an event as plain data."""
    return {"t": event.t, "end": event.end, "finger": event.finger, "kind": event.kind, "words": event.words}


def recorded_rate(feed: Feed) -> dict[str, Any]:
    """Return the status of a scene or a recording: its rate, and the losses of a recording of a port."""
    rates = [
        (len(rows) - 1) / (rows[-1].t - rows[0].t) for rows in feed.rows if len(rows) > 1 and rows[-1].t > rows[0].t
    ]
    counts = getattr(feed.source, "counts", None)
    return {"rate": f"{sum(rates):.0f} frames/s", "losses": "" if counts is None else str(counts), "state": "",
            "recording": "", "warning": ""}  # fmt: skip
